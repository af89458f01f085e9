#!/bin/sh
#SBATCH --job-name=@NAME@
#SBATCH --array=1-@PARTS@
#SBATCH --cpus-per-task=@THREADS@
#SBATCH --requeue
#SBATCH --output=@NAME@-%A-%a.log
# Renders @PARTS@ parts of a picture as an array job; the last part to end merges them. Written by `turner farm split` @VERSION@.
# Submit it in a folder that all nodes see: `sbatch FILE`. A part whose file exists is complete: submit again what was lost.
set -eu
mkdir -p @FOLDER@
part=$SLURM_ARRAY_TASK_ID
file=@FOLDER@/part-$(printf %06d "$part").turner-checkpoint
work=@FOLDER@/rendering-$(printf %06d "$part").turner-checkpoint
if [ ! -s "$file" ]; then
    srun turner render @SCENE@ --quiet --threads @THREADS@ --part "$part/@PARTS@" -o "$work" --resume@OPTIONS@
    mv "$work" "$file" || [ -s "$file" ]
fi
if [ "$(ls @FOLDER@/part-*.turner-checkpoint | wc -l)" -eq @PARTS@ ]; then
    # Two parts that end together both merge: the picture has the same bytes and appears whole.
    turner merge @FOLDER@/part-*.turner-checkpoint -o @PICTURE@
fi
