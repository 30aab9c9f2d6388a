# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Debian packages of other architectures, and sources, without a change to the machine: apt with its state in a folder.

# debian_apt FOLDER ARCHITECTURE ARGUMENT...: apt-get for that architecture.
debian_apt() {
    local folder=$1 architecture=$2
    shift 2
    apt-get -q -o "APT::Architecture=$architecture" -o "APT::Architectures=$architecture" \
        -o "Dir::State=$folder/state" -o "Dir::State::status=$folder/status" -o "Dir::Cache=$folder/cache" \
        -o "Dir::Etc::sourcelist=$folder/none" -o "Dir::Etc::sourceparts=$folder/sources" \
        -o "APT::Sandbox::User=$(id -un)" "$@"
}

# debian_lists FOLDER ARCHITECTURE: fetches the lists, those of sources too.
debian_lists() {
    local folder=$1 file
    mkdir -p "$folder/state/lists/partial" "$folder/cache/archives/partial" "$folder/sources"
    : >"$folder/status"
    for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources; do
        [ ! -f "$file" ] || sed -e 's/^Types: deb$/Types: deb deb-src/' -e 's/^deb \(.*\)/deb \1\ndeb-src \1/' \
            "$file" >"$folder/sources/${file##*/}"
    done
    debian_apt "$folder" "$2" update
}
