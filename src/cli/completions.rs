//! `motorlab completions`: completion scripts for shells.

use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;

use super::{CommandLine, Failure, Output, Status};

/// Print the completion script of a shell. Those of bash, zsh, fish and PowerShell also complete profiles with shares and times,
/// columns, effects and their parameters; `motorlab names` lists them.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  motorlab completions bash > ~/.local/share/bash-completion/completions/motorlab\n  motorlab completions powershell >> $PROFILE"
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
        let script = without_hidden(String::from_utf8_lossy(&script).trim_end());
        output.line(&match self.shell {
            Shell::Bash => format!("{script}\n{IN_BASH}"),
            Shell::Fish => format!("{script}\n{IN_FISH}"),
            Shell::Zsh => in_zsh(&script),
            Shell::PowerShell => script.replacen(ASKED_BY_POWERSHELL, IN_POWERSHELL, 1),
            _ => script,
        })?;
        Ok(Status::Done)
    }
}

/// The script without hidden options, which the generator for bash would propose.
fn without_hidden(script: &str) -> String {
    const PROPOSED: &str = "opts=\"";
    let command = CommandLine::command();
    let arguments = command.get_subcommands().flat_map(Command::get_arguments);
    let hidden: Vec<String> = arguments
        .filter(|argument| argument.is_hide_set())
        .filter_map(|argument| Some(format!(" --{} ", argument.get_long()?)))
        .collect();
    let line = |line: &str| match line.trim_start().starts_with(PROPOSED) {
        true => hidden
            .iter()
            .fold(line.to_owned(), |line, option| line.replace(option, " ")),
        false => line.to_owned(),
    };
    script.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// Completions that the program supplies. bash passes the part of a word after its last word break, except for a
/// quoted word.
const IN_BASH: &str = r#"
_motorlab_names() {
    local typed=${COMP_LINE:0:COMP_POINT} word before quoted= kept= candidate i
    word=${typed##*[[:space:]]}
    before=${typed%"$word"}
    before=${before%"${before##*[![:space:]]}"}
    before=${before##*[[:space:]]}
    case $word in [\'\"]*) quoted=1 word=${word:1} ;; esac
    if [ -z "$quoted" ]; then
        for ((i = 0; i < ${#word}; i++)); do
            case $COMP_WORDBREAKS in *"${word:i:1}"*) kept=${word:0:i+1} ;; esac
        done
    fi
    COMPREPLY=()
    while IFS= read -r candidate; do
        if [ -n "$candidate" ]; then COMPREPLY+=("${candidate#"$kept"}"); fi
    done < <(motorlab names --completing="$before" -- "$word" 2>/dev/null)
    [ ${#COMPREPLY[@]} -gt 0 ] || return 1
    compopt -o nospace 2>/dev/null
    return 0
}
_motorlab_or_names() { _motorlab_names || _motorlab "$@"; }
if [[ "${BASH_VERSINFO[0]}" -eq 4 && "${BASH_VERSINFO[1]}" -ge 4 || "${BASH_VERSINFO[0]}" -gt 4 ]]; then
    complete -F _motorlab_or_names -o nosort -o bashdefault -o default motorlab
else
    complete -F _motorlab_or_names -o bashdefault -o default motorlab
fi"#;

/// The same for fish, for these options, and where no option precedes the word.
const IN_FISH: &str = r#"
function __motorlab_names
    set -l before (commandline -opc)
    motorlab names --completing=$before[-1] -- (commandline -ct) 2>/dev/null
end
complete -c motorlab -l profile -r -a '(__motorlab_names)'
complete -c motorlab -l columns -r -a '(__motorlab_names)'
complete -c motorlab -l board -r -a '(__motorlab_names)'
complete -c motorlab -a '(__motorlab_names)'"#;

/// The same for zsh, under the name that zsh calls: the generated function has another.
fn in_zsh(script: &str) -> String {
    const ASKED: &str = r#"_motorlab() {
    local -a found
    found=("${(@f)$(motorlab names --completing="${words[CURRENT-1]}" -- "$PREFIX" 2>/dev/null)}")
    if [[ -n "$found" ]]; then
        compadd -S '' -- $found
    else
        _motorlab_generated "$@"
    fi
}

_motorlab_generated() {"#;
    script.replacen("_motorlab() {", ASKED, 1)
}

const ASKED_BY_POWERSHELL: &str = "    param($wordToComplete, $commandAst, $cursorPosition)\n";

/// The same for PowerShell: the previous word is the last one that ends before the cursor.
const IN_POWERSHELL: &str = r#"    param($wordToComplete, $commandAst, $cursorPosition)

    $before = @($commandAst.CommandElements | Where-Object { $_.Extent.EndOffset -lt $cursorPosition })
    $named = @(& motorlab names "--completing=$($before[-1].Extent.Text)" -- "$wordToComplete" 2>$null | Where-Object { $_ })
    if ($named.Count -gt 0) {
        return $named | ForEach-Object { [CompletionResult]::new($_, $_, [CompletionResultType]::ParameterValue, $_) }
    }
"#;
