//! Text of `motorlab` and `motorlab --help`: the commands of the tour first, the others by their purpose.

pub(super) const SHORT_HELP: &str = "motorlab records a DC motor over serial, simulates it, compares the two, and says which effect explains the error.

  motorlab demo                     all of it, without hardware
  motorlab capture PORT             record a run (motorlab ports lists the ports)
  motorlab import LOG               read a log of another program
  motorlab check RUN                look at a recording itself
  motorlab diagnose RUN             say which effect explains the error

All commands: motorlab --help. One command: motorlab COMMAND --help.";

/// Template of the program's help; the parser fills in the braces.
pub(super) const TEMPLATE: &str = "{about-with-newline}
{usage-heading} {usage}

Tour:
  capture      Record a run from a board, or from a virtual one
                 motorlab capture virtual: --ts 0.03 -o step30.csv
  check        Find errors of the recordings themselves
                 motorlab check step30.csv
  compare      Compare recorded runs with their simulation
                 motorlab compare step30.csv --motor motor.toml --html gap.html
  diagnose     Identify the effects that cause the error
                 motorlab diagnose step30.csv --motor motor.toml --html why.html
  design       List what a profile cannot show, and plan the next recording
                 motorlab design --profile step --ts 0.03

Record and import:
  ports        List serial ports, lab boards first
  import       Convert a log of another program into a run file
  replay       Play a raw serial log into a run file, or as a serial device
  virtual      Plug in a virtual board that any program may open (not on Windows)
  firmware     Write the Arduino sketch for the board into a folder
  flash        Put the sketch onto a board

Motor and effects:
  motor        Write a motor file, or print one with all defaults
  simulate     Simulate the motor through a profile
  effects      List the effects, with values for your motor
  explain      Print the page of an effect
  export       Write a motor or a run for other programs

Classes, fleets and tests:
  demo         Record virtual boards, diagnose an error, show the page
  lab          Work through the lab handout, for one bench or a class
  tabulate     Collect many diagnoses in tables and one page
  blind        Check diagnoses on cases whose cause is sealed

Reference:
  names        List profiles, columns, effects and keys of a virtual board
  schema       Print the JSON Schema of a document
  completions  Print the completion script of a shell
  man          Write manual pages into a folder
  help         Print the help of a command

Options:
{options}

motorlab COMMAND --help has every flag of a command. Flags that all commands share may stand in motorlab.toml
beside the runs: docs/reference/commands.md.
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::CommandLine;
    use clap::{CommandFactory, Parser};

    /// Every command is in the help exactly once.
    #[test]
    fn the_help_lists_every_command_once() {
        let command = CommandLine::command();
        let named = |name: &str| {
            let starts = |line: &&str| {
                line.strip_prefix("  ")
                    .is_some_and(|line| line.split(' ').next() == Some(name))
            };
            TEMPLATE.lines().filter(starts).count()
        };
        for subcommand in command.get_subcommands() {
            assert_eq!(named(subcommand.get_name()), 1, "{}", subcommand.get_name());
        }
        let listed = TEMPLATE
            .lines()
            .filter(|line| line.starts_with("  ") && !line.starts_with("   "));
        assert_eq!(
            listed.count(),
            command.get_subcommands().count() + 1,
            "and `help`"
        );
    }

    #[test]
    fn the_examples_of_the_help_are_command_lines() {
        let examples = TEMPLATE
            .lines()
            .map(str::trim)
            .filter(|line| line.starts_with("motorlab ") && !line.contains("COMMAND"));
        let examples: Vec<&str> = examples.collect();
        assert_eq!(examples.len(), 5);
        for line in examples {
            CommandLine::try_parse_from(line.split(' '))
                .unwrap_or_else(|error| panic!("{line}: {error}"));
        }
    }
}
