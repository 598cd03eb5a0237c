//! Rendering of the notation of [`super::equations`] in a language.

use super::constants::Constant;
use super::equations::{Equations, Function, Line};

/// A language: its syntax of assignments, arrays and functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Language {
    C,
    Python,
    /// MATLAB and Octave.
    Matlab,
}

impl Language {
    /// The language's function for one of the notation's.
    fn function_name(self, word: &str) -> Option<&'static str> {
        Some(match (self, word) {
            (Self::C, "mag") => "fabs",
            (Self::C, "low") => "fmin",
            (Self::C, "high") => "fmax",
            (Self::Matlab, "mag") => "abs",
            (Self::Matlab, "sgn") => "sign",
            (Self::Matlab, "low") => "min",
            (Self::Matlab, "high") => "max",
            _ => return None,
        })
    }

    pub(super) fn expression(self, text: &str) -> String {
        let mut out = String::new();
        for (word, is_word) in words(text) {
            match self.function_name(word).filter(|_| is_word) {
                Some(name) => out += name,
                None if self == Self::Matlab && is_word && is_constant(word) => {
                    out += "c.";
                    out += word;
                }
                None if self == Self::Matlab && word.contains("!=") => {
                    out += &word.replace("!=", "~=")
                }
                None => out += word,
            }
        }
        out
    }

    pub(super) fn comment(self, text: &str) -> String {
        match self {
            Self::C => format!("/* {text} */"),
            Self::Python => format!("# {text}"),
            Self::Matlab => format!("% {text}"),
        }
    }

    fn assign(self, name: &str, expression: &str) -> String {
        let expression = self.expression(expression);
        match self {
            Self::C => format!("    const double {name} = {expression};\n"),
            Self::Python => format!("    {name} = {expression}\n"),
            Self::Matlab => format!("    {name} = {expression};\n"),
        }
    }

    fn element(self, array: &str, k: usize) -> String {
        match self {
            Self::C | Self::Python => format!("{array}[{k}]"),
            Self::Matlab => format!("{array}({})", k + 1),
        }
    }

    /// Assigns those elements of an array that are used to their names.
    fn unpack(self, array: &str, names: &[&str], used: &dyn Fn(&str) -> bool) -> String {
        let named = names.iter().enumerate().filter(|(_, name)| used(name));
        named
            .map(|(k, name)| self.assign(name, &self.element(array, k)))
            .collect()
    }

    pub(super) fn constant(self, constant: &Constant) -> String {
        let Constant {
            name,
            value,
            unit,
            meaning,
        } = constant;
        let unit = if unit.is_empty() { "1" } else { unit };
        let note = self.comment(&format!("{unit}: {meaning}"));
        match self {
            Self::C => format!("#define {name} ({value:?}) {note}\n"),
            Self::Python => format!("{name} = {value:?}  {note}\n"),
            Self::Matlab => format!("    c.{name} = {value:?}; {note}\n"),
        }
    }

    /// A function. MATLAB's functions share no variables: they get the constants as a structure `c`.
    pub(super) fn function(self, function: &Function, equations: &Equations) -> String {
        let lines = needed(function);
        let mut text: Vec<&str> = function.gives.iter().map(String::as_str).collect();
        for line in &lines {
            match line {
                Line::Let(_, expression) => text.push(expression),
                Line::Call(_, _, arguments, _) => text.push(arguments),
            }
        }
        let used = |name: &str| text.iter().any(|text| names(text, name));
        let mut body = String::new();
        for array in function.parameters {
            match *array {
                "y" => body += &self.unpack("y", &equations.y, &used),
                "m" => body += &self.unpack("m", &equations.m, &used),
                _ => {}
            }
        }
        for line in &lines {
            match line {
                Line::Let(name, expression) => body += &self.assign(name, expression),
                Line::Call(array, called, arguments, gives) => {
                    body += &match self {
                        Self::C => format!(
                            "    double {array}[{}];\n    {called}({arguments}, {array});\n",
                            gives.len()
                        ),
                        Self::Python => format!("    {array} = {called}({arguments})\n"),
                        Self::Matlab => format!("    {array} = {called}(c, {arguments});\n"),
                    };
                    body += &self.unpack(array, gives, &used);
                }
            }
        }
        let (name, note) = (function.name, self.comment(function.comment));
        let gives: Vec<String> = function
            .gives
            .iter()
            .map(|text| self.expression(text))
            .collect();
        match self {
            Self::C => {
                let parameters: Vec<String> = function
                    .parameters
                    .iter()
                    .map(|p| {
                        if matches!(*p, "y" | "m") {
                            format!("const double *{p}")
                        } else {
                            format!("double {p}")
                        }
                    })
                    .collect();
                let gives: String = gives
                    .iter()
                    .enumerate()
                    .map(|(k, text)| format!("    out[{k}] = {text};\n"))
                    .collect();
                format!(
                    "{note}\nstatic void {name}({}, double *out)\n{{\n{body}{gives}}}\n",
                    parameters.join(", ")
                )
            }
            Self::Python => format!(
                "def {name}({}):\n    {note}\n{body}    return (\n        {},\n    )\n",
                function.parameters.join(", "),
                gives.join(",\n        ")
            ),
            Self::Matlab => format!(
                "function out = {name}(c, {})\n    {note}\n{body}    out = [{}];\nend\n",
                function.parameters.join(", "),
                gives.join(", ...\n           ")
            ),
        }
    }
}

/// A text split into words (letters, digits, underscores) and separators.
fn words(text: &str) -> Vec<(&str, bool)> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut out = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let kind = is_word(first);
        let end = rest.find(|c| is_word(c) != kind).unwrap_or(rest.len());
        out.push((&rest[..end], kind));
        rest = &rest[end..];
    }
    out
}

/// Constants, and only they, are in capitals.
fn is_constant(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_uppercase())
}

pub(super) fn names(text: &str, name: &str) -> bool {
    words(text).contains(&(name, true))
}

/// The lines of a function whose results are used.
fn needed(function: &Function) -> Vec<Line> {
    let mut texts: Vec<String> = function.gives.clone();
    let mut kept = Vec::new();
    for line in function.lines.iter().rev() {
        let used = |name: &&str| texts.iter().any(|text| names(text, name));
        let (is_used, text) = match line {
            Line::Let(name, expression) => (used(name), expression.clone()),
            Line::Call(_, _, arguments, gives) => (gives.iter().any(used), (*arguments).to_owned()),
        };
        if is_used {
            texts.push(text);
            kept.push(line.clone());
        }
    }
    kept.reverse();
    kept
}
