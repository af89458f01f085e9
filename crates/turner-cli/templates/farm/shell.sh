#!/bin/sh
# Renders @PARTS@ parts of a picture and merges them. Written by `turner farm split` @VERSION@.
# A part whose file exists is complete and is not rendered again, one that was stopped continues.
set -eu
mkdir -p @FOLDER@
part=1
while [ "$part" -le @PARTS@ ]; do
    file=@FOLDER@/part-$(printf %06d "$part").turner-checkpoint
    work=@FOLDER@/rendering-$(printf %06d "$part").turner-checkpoint
    if [ ! -s "$file" ]; then
        turner render @SCENE@ --quiet --threads @THREADS@ --part "$part/@PARTS@" -o "$work" --resume@OPTIONS@
        mv "$work" "$file" || [ -s "$file" ]
    fi
    part=$((part + 1))
done
turner merge @FOLDER@/part-*.turner-checkpoint -o @PICTURE@
