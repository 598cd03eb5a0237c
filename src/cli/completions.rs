//! `motorlab completions`: completion scripts for shells.

use std::fmt::Write as _;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::names::{SHARES, TIMES, parameters_of};
use super::virtual_spec::BOARD_KEYS;
use super::{CommandLine, Failure, Output, Status};
use crate::board::BUILT_IN;
use crate::board::text_lines::Column;
use crate::motor::Parameters;
use crate::motor::catalogue::{Stage, catalogue};

/// Print the completion script of a shell. That of bash also completes profiles with shares and times, columns, effects and their
/// parameters; `motorlab names` lists them for every shell.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  motorlab completions bash > ~/.local/share/bash-completion/completions/motorlab"
)]
pub struct Completions {
    /// Which shell.
    shell: Shell,
}

impl Completions {
    pub(super) fn run(&self, output: &Output) -> Result<Status, Failure> {
        let mut script = Vec::new();
        clap_complete::generate(
            self.shell,
            &mut CommandLine::command(),
            "motorlab",
            &mut script,
        );
        let mut script = String::from_utf8_lossy(&script).trim_end().to_owned();
        if self.shell == Shell::Bash {
            script.push_str(&names_in_bash());
        }
        output.line(&script)?;
        Ok(Status::Done)
    }
}

/// What the generated script does not know: names inside one word, such as the effect in `virtual:?effect=`. The part of the word that is
/// there already stays (`stem`); bash is told of what stands behind the last character at which it breaks words.
const IN_BASH: &str = r#"
_motorlab_names() {
    local typed=${COMP_LINE:0:COMP_POINT} word before quoted= stem= list= effect candidate kept i
    word=${typed##*[[:space:]]}
    before=${typed%"$word"}
    before=${before%"${before##*[![:space:]]}"}
    before=${before##*[[:space:]]}
    case $word in [\'\"]*) quoted=1 word=${word:1} ;; esac
    case $before in
        --profile=* | --columns=*) return 1 ;;
        --profile)
            case $word in
                *,*) stem=${word%,*}, list=$_motorlab_times ;;
                *@*) stem=${word%@*}@ list=$_motorlab_shares ;;
                *) list=$_motorlab_profiles ;;
            esac
            ;;
        --columns)
            case $word in *,*) stem=${word%,*}, ;; esac
            list=$_motorlab_columns
            ;;
        effects) list="$_motorlab_effects $_motorlab_stages" ;;
        *)
            case $before,$word in
                --board,* | *,virtual:*) ;;
                *) return 1 ;;
            esac
            stem=${word%"${word##*[&?:]}"}
            if [ "$stem" = virtual: ]; then stem=virtual:?; fi
            candidate=${word#"$stem"}
            case $candidate in
                effect=*) stem+=effect= list=$_motorlab_effects ;;
                *)
                    effect=${stem##*effect=}
                    list="$(_motorlab_parameters "${effect%%&*}") $_motorlab_keys"
                    ;;
            esac
            ;;
    esac
    # What bash has of the word lies behind the last of its breaks, but for a word in quotes.
    kept=
    if [ -z "$quoted" ]; then
        for ((i = 0; i < ${#word}; i++)); do
            case $COMP_WORDBREAKS in *"${word:i:1}"*) kept=${word:0:i+1} ;; esac
        done
    fi
    COMPREPLY=()
    for candidate in $list; do
        candidate=$stem$candidate
        case $candidate in "$word"*) COMPREPLY+=("${candidate#"$kept"}") ;; esac
    done
    compopt -o nospace 2>/dev/null
    return 0
}
_motorlab_or_names() { _motorlab_names || _motorlab "$@"; }
if [[ "${BASH_VERSINFO[0]}" -eq 4 && "${BASH_VERSINFO[1]}" -ge 4 || "${BASH_VERSINFO[0]}" -gt 4 ]]; then
    complete -F _motorlab_or_names -o nosort -o bashdefault -o default motorlab
else
    complete -F _motorlab_or_names -o bashdefault -o default motorlab
fi"#;

fn names_in_bash() -> String {
    let mut script = String::from(
        "\n\n# Names inside words: profiles, columns, effects and their parameters.\n",
    );
    let mut list = |name: &str, words: Vec<&str>| {
        let _ = writeln!(script, "_motorlab_{name}='{}'", words.join(" "));
    };
    list("profiles", BUILT_IN.map(|(name, _)| name).into());
    list("shares", SHARES.into());
    list("times", TIMES.into());
    list(
        "columns",
        Column::printed().into_iter().map(Column::name).collect(),
    );
    list("effects", catalogue().iter().map(|kind| kind.id).collect());
    list("stages", Stage::ALL.map(Stage::id).into());
    let board = BOARD_KEYS.iter().map(|(key, _)| *key);
    let keys: Vec<String> = ["effect"]
        .into_iter()
        .chain(board)
        .chain(Parameters::KEYS)
        .map(|key| format!("{key}="))
        .collect();
    list("keys", keys.iter().map(String::as_str).collect());
    script.push_str("_motorlab_parameters() {\n    case $1 in\n");
    for kind in catalogue()
        .iter()
        .filter(|kind| !kind.parameters.is_empty())
    {
        let keys: Vec<String> = parameters_of(kind)
            .iter()
            .map(|key| format!("{key}="))
            .collect();
        let _ = writeln!(script, "        {}) echo '{}' ;;", kind.id, keys.join(" "));
    }
    script.push_str("    esac\n}");
    script.push_str(IN_BASH);
    script
}
