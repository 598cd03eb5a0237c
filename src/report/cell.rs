//! Table cells of a page: texts, drawings, and links to other pages.

use std::fmt::Write;

use super::escape::{escaped, with_code};
use super::html::is_number;
use super::{Panel, thumbnail};

/// A table cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// The curves of a panel over time, small.
    Drawing(Panel),
    /// Names, each with the path of its page relative to this page, if it has one.
    Links(Vec<(String, Option<String>)>),
}

impl Cell {
    /// The visible text.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Drawing(panel) => panel.y_label.clone(),
            Self::Links(links) => {
                let names = links.iter().map(|(name, _)| name.as_str());
                names.collect::<Vec<_>>().join(", ")
            }
        }
    }

    /// Whether it is a number, alone or with its unit; dates of links are not.
    pub(super) fn is_number(&self) -> bool {
        matches!(self, Self::Text(text) if is_number(text))
    }

    pub(super) fn markup(&self) -> String {
        let link = |(name, page): &(String, Option<String>)| match page {
            Some(page) => format!("<a href=\"{}\">{}</a>", address(page), escaped(name)),
            None => format!("<span class=\"whole\">{}</span>", escaped(name)),
        };
        match self {
            Self::Text(text) => breakable(&with_code(text)),
            Self::Drawing(panel) => thumbnail::inline(panel, "s"),
            Self::Links(links) => links.iter().map(link).collect::<Vec<_>>().join(", "),
        }
    }
}

/// A path as a URL reference (RFC 3986): it begins with a dot, so that no part of it is parsed as a scheme.
fn address(path: &str) -> String {
    let mut out = String::from("./");
    for byte in path.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                out.push(char::from(byte));
            }
            _ => {
                let _ = write!(out, "%{byte:02X}");
            }
        }
    }
    out
}

/// Rows of texts as cells.
pub(super) fn of_texts(rows: &[Vec<String>]) -> Vec<Vec<Cell>> {
    let of_row = |row: &Vec<String>| row.iter().cloned().map(Cell::Text).collect();
    rows.iter().map(of_row).collect()
}

/// A text that may wrap after the `+` of a set of effects, so that the column is as wide as one name.
pub(super) fn breakable(html: &str) -> String {
    let mut parts = html.split('+');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let joins = part.starts_with(char::is_alphabetic);
        out.push_str(if joins { "+<wbr>" } else { "+" });
        out.push_str(part);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_a_path_for_any_file_name() {
        let page = "a b/javascript:1\"#?.html".to_owned();
        let cell = Cell::Links(vec![("<1>".to_owned(), Some(page)), ("2".to_owned(), None)]);
        assert_eq!(
            cell.markup(),
            "<a href=\"./a%20b/javascript%3A1%22%23%3F.html\">&lt;1&gt;</a>, <span class=\"whole\">2</span>"
        );
        assert_eq!(cell.text(), "<1>, 2");
    }
}
