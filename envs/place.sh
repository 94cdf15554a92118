#!/bin/sh
# Print where `make` has its environment, for a folder as seen from the project, such as .venv.
# Snakemake writes the path of its interpreter unquoted into a command of the shell. Where that path
# would need quotes, the environment is in BREAKER_ENV, or in the cache under a checksum of the
# folder's path, and the folder is a link to it. A second word, `moved`, says that what is there
# was made for another path. If the other place needs quotes, too, print `refused moved`.
needs_quotes() {
    case $1 in
        *[[:space:]\!\"\#\$\&\'\(\)\*:\;\<\>\?\[\\\`\{\|\}\~]*) true ;;
        *) false ;;
    esac
}

case $1 in
    /*) folder=$1 ;;
    *) folder=$(pwd -P)/$1 ;;
esac
if needs_quotes "$folder"; then
    sum=$(printf %s "$folder" | cksum | cut -d ' ' -f 1)
    place=${BREAKER_ENV:-${XDG_CACHE_HOME:-$HOME/.cache}/breaker-$sum}
else
    place=$folder
fi
case $place in
    /*) needs_quotes "$place" && place=refused ;;
    *) place=refused ;;
esac
# A developer's own link in a folder that needs no quotes is followed.
if [ "$place" = "$folder" ] && [ -L "$folder" ]; then
    made=$place
else
    made=$(sed -n 's/^command = .* //p' "$folder/pyvenv.cfg" 2>/dev/null)
fi
[ "${made:-$place}" = "$place" ] && [ "$place" != refused ] || place="$place moved"
printf '%s\n' "$place"
