#!/bin/sh
# Renders @PARTS@ parts of a picture by GNU parallel and merges them. Written by `turner farm split` @VERSION@.
# Add machines by the environment: PARALLEL="--sshlogin a,b --workdir ." (they must see this folder).
# A part whose file exists is complete and is not rendered again, one that was stopped continues; one that fails is tried three times.
set -eu
mkdir -p @FOLDER@
# The script may come from a pipe: each part runs a copy of it.
script=@FOLDER@/render-part.sh
cat > "$script" <<'PART'
set -eu
file=@FOLDER@/part-$(printf %06d "$1").turner-checkpoint
work=@FOLDER@/rendering-$(printf %06d "$1").turner-checkpoint
if [ ! -s "$file" ]; then
    turner render @SCENE@ --quiet --threads @THREADS@ --part "$1/@PARTS@" -o "$work" --resume@OPTIONS@
    mv "$work" "$file" || [ -s "$file" ]
fi
PART
seq @PARTS@ | parallel --retries 3 --halt soon,fail=1 sh "$script" {}
turner merge @FOLDER@/part-*.turner-checkpoint -o @PICTURE@
