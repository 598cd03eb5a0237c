//! One self-contained HTML file: text, tables and drawings, without network, light and dark, phone and desktop.
//!
//! All content is escaped; only this module writes markup.

use std::fmt::Write;

use super::bars::Bars;
use super::cell::{Cell, of_texts};
use super::escape::{escaped, with_code};
use super::explore;
use super::figure::Figure;
use super::matrix::Matrix;
use super::strip::Strip;
use super::svg::{self, Size};

const STYLE: &str = include_str!("page.css");

/// Width of a drawing on a phone in pixels.
const PHONE: u32 = 360;
/// Letters above which a cell counts as a sentence.
const SENTENCE: usize = 50;

/// A page under construction.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    body: String,
    /// Whether a figure is interactive.
    is_live: bool,
}

impl Page {
    /// A page with its heading.
    pub fn new(title: &str) -> Self {
        Self {
            title: title.to_owned(),
            body: format!("<h1>{}</h1>\n", escaped(title)),
            is_live: false,
        }
    }

    /// The summary sentence.
    pub fn lead(&mut self, text: &str) {
        self.element("p class=\"lead\"", "p", text);
    }

    /// Named parts of a text; text between backticks is a command.
    pub fn parts(&mut self, parts: &[(&str, String)]) {
        self.body.push_str("<dl class=\"lead\">");
        for (name, text) in parts {
            let _ = write!(self.body, "<dt>{}</dt><dd>", escaped(name));
            for (k, part) in text.split('`').enumerate() {
                // A command is on a line of its own, so that the full stop after it is dropped.
                let part = match k {
                    0 => part,
                    _ => part.trim_start_matches(['.', ' ']),
                };
                let part = escaped(part);
                let _ = match k % 2 {
                    0 => write!(self.body, "{part}"),
                    _ => write!(self.body, "<code>{part}</code>"),
                };
            }
            self.body.push_str("</dd>");
        }
        self.body.push_str("</dl>\n");
    }

    /// A heading of a section.
    pub fn section(&mut self, title: &str) {
        self.element("h2", "h2", title);
    }

    /// A heading inside a section.
    pub fn subsection(&mut self, title: &str) {
        self.element("h3", "h3", title);
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.element("p", "p", text);
    }

    /// The answer to the question in the heading.
    pub fn answer(&mut self, text: &str) {
        self.element("p class=\"answer\"", "p", text);
    }

    /// A remark in small type.
    pub fn note(&mut self, text: &str) {
        self.element("p class=\"note\"", "p", text);
    }

    /// A bulleted list.
    pub fn list<T: AsRef<str>>(&mut self, items: impl IntoIterator<Item = T>) {
        self.body.push_str("<ul>");
        for item in items {
            let _ = write!(self.body, "<li>{}</li>", with_code(item.as_ref()));
        }
        self.body.push_str("</ul>\n");
    }

    /// Preformatted text, such as a file or a formula.
    pub fn verbatim(&mut self, text: &str) {
        let _ = writeln!(self.body, "<pre>{}</pre>", escaped(text));
    }

    /// A displayed formula: `left` and a fraction (MathML).
    pub fn fraction(&mut self, left: &str, numerator: &str, denominator: &str) {
        let _ = writeln!(
            self.body,
            "<p class=\"wide\">{} <math><mstyle displaystyle=\"true\"><mfrac><mtext>{}</mtext><mtext>{}</mtext></mfrac></mstyle></math></p>",
            escaped(left),
            escaped(numerator),
            escaped(denominator)
        );
    }

    /// A table; numeric columns are right-aligned. Two columns of words, and rows with sentences, are stacked on a
    /// phone.
    pub fn table(&mut self, names: &[&str], rows: &[Vec<String>]) {
        self.rows(names, &of_texts(rows), None);
    }

    /// A table with links to other pages.
    pub fn linked_table(&mut self, names: &[&str], rows: &[Vec<Cell>]) {
        self.rows(names, rows, None);
    }

    /// A table that is sorted by a click on a column's name.
    pub fn sortable(&mut self, names: &[&str], rows: &[Vec<String>]) {
        self.is_live = true;
        self.rows(names, &of_texts(rows), Some("sortable"));
    }

    fn rows(&mut self, names: &[&str], rows: &[Vec<Cell>], class_name: Option<&str>) {
        let numeric: Vec<bool> = (0..names.len())
            .map(|k| {
                !rows.is_empty()
                    && rows
                        .iter()
                        .all(|row| row.get(k).is_some_and(Cell::is_number))
            })
            .collect();
        let class = |k: usize| {
            if numeric.get(k) == Some(&true) {
                " class=\"number\""
            } else {
                ""
            }
        };
        let is_sentence = |cell: &Cell| cell.text().chars().count() > SENTENCE;
        let has_sentences = rows.iter().flatten().any(is_sentence);
        let prose = (names.len() == 2 || has_sentences) && !numeric.contains(&true);
        let _ = write!(
            self.body,
            "<div class=\"wide\"><table{}><thead><tr>",
            match class_name.or(prose.then_some("prose")) {
                Some(name) => format!(" class=\"{name}\""),
                None => String::new(),
            }
        );
        for (k, name) in names.iter().enumerate() {
            let _ = write!(self.body, "<th{}>{}</th>", class(k), escaped(name));
        }
        self.body.push_str("</tr></thead><tbody>");
        for row in rows {
            self.body.push_str("<tr>");
            for (k, cell) in row.iter().enumerate() {
                // A number and its percent sign stay on one line.
                let cell = match numeric.get(k) {
                    Some(true) => escaped(&cell.text().replace(" %", "\u{a0}%")).into_owned(),
                    _ => cell.markup(),
                };
                let _ = write!(self.body, "<td{}>{cell}</td>", class(k));
            }
            self.body.push_str("</tr>");
        }
        self.body.push_str("</tbody></table></div>\n");
    }

    /// A drawing with its caption; rendered a second time at a phone's width, so that its text stays readable.
    pub fn figure(&mut self, figure: &Figure, size: Size, caption: &str) {
        self.is_live = true;
        let _ = writeln!(
            self.body,
            "<figure data-plot=\"{}\"><div class=\"broad\">{}</div><div class=\"narrow\">{}</div><figcaption>{}</figcaption></figure>",
            escaped(&explore::data(figure, size)),
            svg::inline(figure, size),
            svg::inline(
                figure,
                Size {
                    width: PHONE,
                    ..size
                }
            ),
            escaped(caption)
        );
    }

    /// Small drawings side by side, stacked on a phone, each with its caption.
    pub fn figures<'a>(&mut self, figures: impl IntoIterator<Item = (&'a Figure, &'a str)>) {
        self.body.push_str("<div class=\"grid\">");
        for (figure, caption) in figures {
            self.is_live = true;
            let _ = write!(
                self.body,
                "<figure data-plot=\"{}\">{}<figcaption>{}</figcaption></figure>",
                escaped(&explore::data(figure, Size::HALF)),
                svg::inline(figure, Size::HALF),
                escaped(caption)
            );
        }
        self.body.push_str("</div>\n");
    }

    /// A bar chart with its caption.
    pub fn bars(&mut self, bars: &Bars, caption: &str) {
        self.in_both_widths(|width| bars.inline(width), caption);
    }

    /// A strip chart with its caption.
    pub fn strip(&mut self, strip: &Strip, caption: &str) {
        self.in_both_widths(|width| strip.inline(width), caption);
    }

    /// Content that is expanded by a click.
    pub fn folded(&mut self, summary: &str, content: impl FnOnce(&mut Self)) {
        let _ = writeln!(
            self.body,
            "<details><summary>{}</summary>",
            escaped(summary)
        );
        content(self);
        self.body.push_str("</details>\n");
    }

    /// A drawing wider than a phone, with its caption.
    pub(super) fn drawing(&mut self, svg: &str, caption: &str) {
        let _ = writeln!(
            self.body,
            "<figure><div class=\"wide\">{svg}</div><figcaption>{}</figcaption></figure>",
            escaped(caption)
        );
    }

    /// A matrix of counts with its caption.
    pub fn matrix(&mut self, matrix: &Matrix, caption: &str) {
        let _ = writeln!(
            self.body,
            "<figure class=\"wide\">{}<figcaption>{}</figcaption></figure>",
            matrix.inline(),
            escaped(caption)
        );
    }

    /// A drawing for a screen and one for a phone: the style sheet shows one of them.
    fn in_both_widths(&mut self, drawn: impl Fn(u32) -> String, caption: &str) {
        let _ = writeln!(
            self.body,
            "<figure><div class=\"broad\">{}</div><div class=\"narrow\">{}</div><figcaption>{}</figcaption></figure>",
            drawn(Size::PAGE.width),
            drawn(PHONE),
            escaped(caption)
        );
    }

    fn element(&mut self, open: &str, close: &str, text: &str) {
        let _ = writeln!(self.body, "<{open}>{}</{close}>", with_code(text));
    }

    /// The HTML file.
    pub fn finish(self) -> String {
        let [licence, uplot, script] = explore::SCRIPT;
        let (style, script) = match self.is_live {
            true => (
                explore::STYLE.concat(),
                format!("<script>/*\n{licence}\n*/\n{uplot}\n{script}</script>\n"),
            ),
            false => (String::new(), String::new()),
        };
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>{}</title>\
<style>{STYLE}{}{style}</style></head>\n<body>\n{}<footer>motorlab {}</footer>\n{script}</body></html>\n",
            escaped(&self.title),
            svg::STYLE,
            self.body,
            env!("CARGO_PKG_VERSION"),
        )
    }
}

/// Whether a cell is a number, alone or with its unit after a space.
pub(super) fn is_number(cell: &str) -> bool {
    let cell = cell.trim_start_matches(['-', '\u{2212}', '+', '\u{b1}', '<', '>', ' ', '\u{a0}']);
    let digits = cell.split(char::is_whitespace).next().unwrap_or("");
    let of_a_number = |c: char| c.is_numeric() || ".,e-\u{2212}+\u{d7}\u{207b}%:".contains(c);
    cell.is_empty()
        || cell == "\u{2013}"
        || (digits.starts_with(|c: char| c.is_ascii_digit()) && digits.chars().all(of_a_number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_loads_nothing_from_the_network_and_runs_no_text_of_a_file() {
        let mut page = Page::new("run <script>.csv");
        page.lead("a & b");
        page.table(
            &["file", "samples"],
            &[vec!["<img onerror=x>".into(), "12".into()]],
        );
        let html = page.finish();
        let addresses = html.replace("http://www.w3.org/2000/svg", "");
        assert!(!addresses.contains("http") && !html.contains("<script") && !html.contains("<img"));
        assert!(html.contains("<td class=\"number\">12</td>"));
    }

    #[test]
    fn a_set_of_effects_may_be_wrapped_between_effects() {
        let mut page = Page::new("causes");
        let cells = ["cogging+dead_zone", "+4 %", "a + b"];
        page.sortable(&["", "", ""], &[cells.map(str::to_owned).to_vec()]);
        let html = page.finish();
        assert!(html.contains("<td>cogging+<wbr>dead_zone</td>"));
        assert!(html.contains("+4\u{a0}%<") && html.contains(">a + b<"));
    }

    #[test]
    fn numbers_with_units_are_numbers_and_names_are_not() {
        let numbers = [
            "12",
            "\u{2212}0.5",
            "47.7\u{a0}RPM",
            "3 of 4",
            "8\u{d7}10\u{207b}\u{2076}",
            "+4 %",
            ">\u{a0}0.999",
        ];
        assert!(numbers.into_iter().all(is_number));
        assert!(
            ["1st order", "2.a", "RPM", "0.03s"]
                .into_iter()
                .all(|cell| !is_number(cell))
        );
    }
}
