#!/usr/bin/env bash
# Turner Studio from end to end, on a display without a screen (Xvfb), driven by mouse and keyboard (xdotool): look
# around, edit a material, add a light, save, and compare the window's finished picture with that of `turner render`.
# Fails at the first difference.
#
# Usage: scripts/studio-end-to-end.sh FOLDER [SCENE]
#   FOLDER  gets a screenshot of each step, the saved scene and both pictures
#   SCENE   a scene with an object in the middle of the picture that has a material; default scenes/hello.toml
# PICTURES=docs/images makes the pictures of docs/studio.md as well.
# Programs: STUDIO, by default target/release/turner-studio, which is built if it is missing; TURNER, by default the command
# line in the studio.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=${1:?usage: scripts/studio-end-to-end.sh FOLDER [SCENE]}
scene=${2:-scenes/hello.toml}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
for program in Xvfb xdotool import convert cmp; do
    command -v "$program" >/dev/null || { echo "error: $program is needed" >&2; exit 2; }
done
studio=${STUDIO:-target/release/turner-studio}
[ -x "$studio" ] || cargo build --release --locked -p turner-studio
turner() { if [ -n "${TURNER:-}" ]; then "$TURNER" "$@"; else "$studio" turner "$@"; fi; }

work=$(mktemp -d)
server= window_process=
cleanup() {
    [ -z "$window_process" ] || kill "$window_process" 2>/dev/null || true
    [ -z "$server" ] || kill "$server" 2>/dev/null || true
    rm -rf "$work"
}
trap cleanup EXIT

say() { printf '%s\n' "$*"; }
fail() {
    say "FAILED: $*" >&2
    shot failed || true
    [ ! -s "$work/log" ] || tail -n 20 "$work/log" >&2
    exit 1
}
number=0
shot() {
    number=$((number + 1))
    import -silent -window root "$folder/$(printf '%02d' "$number")-$1.png"
}
key() { xdotool key --clearmodifiers "$@"; sleep 0.4; }
write() { xdotool type --delay 25 -- "$1"; sleep 0.4; }
# Runs a command of the palette by its name.
command_named() { key ctrl+k; write "$1"; sleep 0.4; key Return; }
# Waits at most $1 seconds until the rest of the arguments succeed.
until_true() {
    local left=$(($1 * 5)); shift
    until "$@"; do
        left=$((left - 1))
        [ "$left" -gt 0 ] || return 1
        kill -0 "$window_process" 2>/dev/null || fail "the window has closed"
        sleep 0.2
    done
}

say "starts a display"
mkfifo "$work/display"
Xvfb -displayfd 3 -noreset -screen 0 1440x900x24 -nolisten tcp 3>"$work/display" 2>/dev/null &
server=$!
read -r display <"$work/display"
export DISPLAY=:$display TURNER_STUDIO_HOME=$work/home LIBGL_ALWAYS_SOFTWARE=1
unset WAYLAND_DISPLAY

window=
found() { window=$(xdotool search --onlyvisible --pid "$window_process" 2>/dev/null | tail -n 1); [ -n "$window" ]; }
title_has() { xdotool getwindowname "$window" | grep -qF -- "$1"; }
open_studio() {
    "$studio" "$1" >"$work/log" 2>&1 &
    window_process=$!
    until_true 60 found || fail "no window has appeared"
    xdotool windowmove "$window" 0 0 windowsize "$window" 1440 900 windowfocus "$window"
    until_true 60 title_has "$(basename "$1") - Turner Studio" || fail "the title does not name the scene"
    sleep 2
}
close_studio() {
    key ctrl+q
    for _ in $(seq 50); do kill -0 "$window_process" 2>/dev/null || break; sleep 0.2; done
    kill -0 "$window_process" 2>/dev/null && fail "the window does not close"
    wait "$window_process" || fail "the studio ended with an error"
    window_process=
}

file=$work/$(basename "$scene")
for beside in textures meshes; do
    [ ! -d "$(dirname "$scene")/$beside" ] || cp -r "$(dirname "$scene")/$beside" "$work/"
done
cp "$scene" "$file"
say "starts the studio with a copy of $scene"
open_studio "$file"
shot opened

# The middle of the picture: the panel of the view is in the middle of the window.
x=690 y=470
say "orbits by dragging in the picture"
xdotool mousemove $x $y mousedown 1
for i in 1 2 3 4 5 6; do xdotool mousemove $((x + 12 * i)) $((y - 4 * i)); sleep 0.05; done
xdotool mouseup 1
until_true 10 title_has "$(basename "$scene")*" || fail "the title does not say that the scene has changed"
sleep 1
shot orbited

say "selects the object in the middle and edits its material by keyboard"
xdotool mousemove $x $y click 1
sleep 1
key m
key e
key Tab; key Tab; key Tab; key Tab
write 0.21875
key Return
sleep 1
shot material

say "adds a light by the palette"
command_named "add point light"
sleep 1
shot light

say "saves"
key ctrl+s
until_true 20 title_has "$(basename "$scene") - Turner Studio" || fail "the title still says that the scene has changed"
shot saved
cp "$file" "$folder/saved.toml"
diff "$scene" "$file" >"$work/changes" && fail "the saved file is the first one"
sed 's/^/    /' "$work/changes"
count() { grep -o '"point"' "$1" | wc -l; }
[ "$(count "$file")" -eq $(($(count "$scene") + 1)) ] || fail "the saved file has no new point light"
grep -q '0\.21875' "$file" || fail "the saved file has no edited material"
head -c 2000 "$scene" | cmp -s - <(head -c 2000 "$file") && fail "the camera has not moved"

say "renders the saved file with turner"
turner render "$file" -o "$folder/turner.png" --quiet || fail "turner cannot render the saved file"
# Both programs write the samples per pixel into the header.
samples() { grep -aoP 'turner:samples\x00\K[0-9]+' "$1" | head -n 1; }
wanted=$(samples "$folder/turner.png")
[ -n "$wanted" ] || fail "turner's picture does not tell its samples"

say "waits for the window's picture to have $wanted samples per pixel and saves it"
save_picture() {
    rm -f "$1"
    key ctrl+e
    key ctrl+a
    write "$1"
    key Return
    until_true 20 test -s "$1" || fail "no picture was saved"
}
finished() { save_picture "$folder/window.png"; [ "$(samples "$folder/window.png")" = "$wanted" ]; }
begun=$SECONDS
until finished; do
    [ $((SECONDS - begun)) -lt "${LIMIT:-300}" ] || fail "the picture has $(samples "$folder/window.png") samples per pixel"
    sleep 2
done
shot finished

pixels() { convert "$1" -depth 8 rgba:-; }
size() { identify -format '%w x %h' "$1"; }
[ "$(size "$folder/window.png")" = "$(size "$folder/turner.png")" ] ||
    fail "the sizes differ: $(size "$folder/window.png") and $(size "$folder/turner.png")"
cmp <(pixels "$folder/window.png") <(pixels "$folder/turner.png") || fail "the pictures differ"
say "equal: $(size "$folder/window.png") pixels, the same bytes"

say "closes the window"
close_studio
say "passed"

# The pictures of docs/studio.md.
[ -n "${PICTURES:-}" ] || exit 0
picture() {
    shot "$1"
    for quality in 88 80 70 60; do
        convert "$folder/$(printf '%02d' "$number")-$1.png" -resize 1200x -quality $quality "$PICTURES/studio-$1.jpg"
        [ "$(stat -c %s "$PICTURES/studio-$1.jpg")" -gt 150000 ] || break
    done
    say "wrote $PICTURES/studio-$1.jpg"
}
open_studio scenes/showcase/glass-still-life.toml
sleep "${PATIENCE:-60}"
xdotool mousemove $x $y click 1
sleep 3
picture window
close_studio
open_studio scenes/classic/001-eight-steps.toml
sleep 3
key x
xdotool mousemove $x $y click 1
command_named "rays panel"
sleep 5
picture rays
close_studio
open_studio scenes/classic/002-09-reflection-texture.toml
command_named "effects panel"
sleep 4
picture 002
close_studio
open_studio scenes/showcase/material-balls.toml
command_named "effects panel"
command_named "scopes panel"
sleep "${PATIENCE:-60}"
picture effects
close_studio
