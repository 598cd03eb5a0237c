# What the parts that run Windows programs share; sourced in the project's folder, with a function `skip_all REASON`.
target=x86_64-pc-windows-gnu
linker=x86_64-w64-mingw32-gcc-win32
# The longest that one call of the program may take, in s: a diagnosis takes a tenth of it.
longest=100
export CARGO_INCREMENTAL=0 CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"

# cargo for Windows programs: with the environment of dist/make, so that both share what they build.
windows_cargo() {
    local command=$1
    shift
    CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=$linker CC_x86_64_pc_windows_gnu=$linker AR_x86_64_pc_windows_gnu=x86_64-w64-mingw32-ar \
        CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER=wine cargo "$command" --quiet --target "$target" "$@"
}

has_target() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; }

# Skips all where a tool is missing.
has_tools() {
    command -v "$linker" >/dev/null 2>&1 || skip_all "no $linker (Debian package gcc-mingw-w64-x86-64-win32)"
    command -v wine >/dev/null 2>&1 || skip_all "no wine (Debian packages wine and wine64)"
    command -v python3 >/dev/null 2>&1 || skip_all "no python3"
    has_target || rustup target add "$target" >/dev/null 2>&1
    has_target || skip_all "no standard library for $target (rustup target add $target)"
}

# A drive C in a folder `work` that goes at the end.
set_up_wine() {
    work=$(mktemp -d)
    export WINEPREFIX=$work/prefix WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml="
    trap 'wineserver -k >/dev/null 2>&1; rm -rf "$work"' EXIT
    # One server for all calls: one that goes down 3 s after the last program may still answer the next, which then ends with status 1.
    mkdir -p "$WINEPREFIX"
    setsid wineserver -p >/dev/null 2>&1
    timeout "$longest" wine wineboot -i >/dev/null 2>&1
    [ -d "$WINEPREFIX/drive_c/windows" ] || { echo "wine makes no drive C" >&2; exit 1; }
}

# The library that the standard library draws random numbers from, in the folder of a program.
bcryptprimitives_in() {
    "$linker" -shared -o "$1/bcryptprimitives.dll" tests/windows/process_prng.c -ladvapi32 || exit 1
}
