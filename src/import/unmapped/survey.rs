//! Survey of the beginning of a log: its format, and the content of its columns.

use super::super::cells::{Cells, Separator, decode, without_groups};
use super::super::labels::labels;
use super::super::lines::{Line, lines};
use super::super::map_file::FileSection;
use super::super::stamp::before_line;
use super::super::table::Table;
use super::column::Column;
use super::column_names::{all_words, cells_of, is_names, name_columns, only_one_of_a_name};
use super::commas::{COMMAS_WITHIN, Width};
use super::table::{BANNER_LINES, Numbered, layout};
use super::thousands::Thousands;

/// Most rows read: a minute at 3 ms.
const ROWS: usize = 20_000;
/// Most comment lines kept.
const COMMENTS: usize = 50;
/// Beginning of a comment.
const COMMENT_MARKS: [&str; 3] = ["#", "%", "//"];

/// Structure of a log.
#[derive(Debug, Default)]
pub(super) struct Survey {
    /// Section of the mapping file.
    pub file: FileSection,
    pub columns: Vec<Column>,
    /// Comment lines before and among the rows, without the mark.
    pub comments: Vec<String>,
    /// Other lines above the rows.
    pub banner: Vec<String>,
    pub rows: usize,
    /// The column whose words divide the runs.
    pub split_by: Option<String>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Contents of the first rows of a table.
pub(super) fn of_table(table: &Table) -> Survey {
    let mut found = Survey::default();
    found.file.delimiter = Some(",".to_owned());
    found.file.names = Some(true);
    found.split_by = table.split_by().map(str::to_owned);
    found.columns = (table.columns.iter())
        .map(|column| Column::named(&column.name, column.unit.clone()))
        .collect();
    only_one_of_a_name(&mut found.columns);
    table.look(ROWS, |cells| {
        found.rows += 1;
        for (at, column) in found.columns.iter_mut().enumerate() {
            column.take(cells.get(at), false);
        }
    });
    found
}

/// Survey of the first bytes of a log. Without a table of numbers, returns the first lines.
pub(super) fn survey(head: &[u8], is_whole: bool) -> Result<Survey, Vec<String>> {
    let all = lines_of(head, is_whole);
    let first_lines = (all.iter().take(3))
        .map(|(_, line)| decode(line).into_owned())
        .collect();
    let mut found = Survey::default();
    let content = |line: &[u8]| {
        before_line(line)
            .map_or(line, |(_, rest)| rest)
            .trim_ascii()
            .to_vec()
    };
    let mark = COMMENT_MARKS
        .into_iter()
        .find(|mark| {
            all.iter()
                .any(|(_, line)| content(line).starts_with(mark.as_bytes()))
        })
        .unwrap_or("#");
    let is_comment = |line: &[u8]| content(line).starts_with(mark.as_bytes());
    let (comments, table): (Vec<Numbered>, Vec<Numbered>) = all
        .into_iter()
        .filter(|(_, line)| !content(line).is_empty())
        .partition(|(_, line)| is_comment(line));
    let text = |line: &[u8]| {
        decode(&content(line))
            .trim_start_matches(mark)
            .trim()
            .to_owned()
    };
    found.comments = comments
        .iter()
        .take(COMMENTS)
        .map(|(_, line)| text(line))
        .collect();
    let Some(layout) = layout(&table) else {
        return Err(first_lines);
    };
    let above = table[..layout.first].iter().rev().take(COMMENTS);
    found.banner = above.map(|(_, line)| decode(line).into_owned()).collect();
    if mark != "#" {
        found.file.comment = Some(mark.to_owned());
    }
    found.file.delimiter = match layout.separator {
        Separator::Byte(b'\t') => Some("tab".to_owned()),
        Separator::Byte(byte) => Some(char::from(byte).to_string()),
        Separator::Blanks => Some("space".to_owned()),
        Separator::Labels => Some("labels".to_owned()),
    };
    found.columns = vec![Column::default(); layout.columns];
    let first_row = table[layout.first].0;
    name_columns(&mut found, &table, &layout);
    if found.file.names == Some(false) {
        // Names in the comment above the rows, as numpy writes them.
        let above = comments.iter().rev().find(|(at, _)| *at < first_row);
        let names = above.map(|(_, line)| cells_of(text(line).as_bytes(), layout.separator));
        if let Some(names) = names.filter(|names| names.len() == layout.columns && all_words(names))
        {
            for (column, name) in found.columns.iter_mut().zip(names) {
                column.name = Some(name);
            }
        }
    }
    if found.file.names == Some(false) && found.columns.iter().all(|one| one.name.is_none()) {
        for (at, name) in found.comments.iter().flat_map(|comment| numbered(comment)) {
            if let Some(column) = at.checked_sub(1).and_then(|at| found.columns.get_mut(at)) {
                column.name.get_or_insert(name);
            }
        }
    }
    let each_row = |take: &mut dyn FnMut(&Cells)| {
        let mut cells = Cells::default();
        cells.expect(labels(&table[layout.first].1).unwrap_or_default());
        for (_, line) in table[layout.first..].iter().take(ROWS) {
            cells.split(line, layout.separator);
            cells.trim_to(layout.columns);
            if cells.len() == layout.columns && !is_names(&cells) {
                take(&cells);
            }
        }
    };
    let mut marks = [b',', b'.'].map(Thousands::of);
    let mut widths: Vec<Width> = vec![Width::default(); layout.columns];
    each_row(&mut |cells| {
        marks.iter_mut().for_each(|mark| mark.take(cells));
        (widths.iter_mut().enumerate()).for_each(|(at, width)| width.take(cells.get(at)));
    });
    let padded = widths.iter().skip(1).position(Width::is_padded);
    if let Some(at) = padded
        && layout.separator == Separator::Byte(b',')
        && found.file.names == Some(false)
    {
        let why = format!(
            "column {} is written as the decimals of a number are, such as 05",
            at + 2
        );
        found.notes.push(format!("{why}; {COMMAS_WITHIN}"));
    }
    let thousands = marks.iter().find_map(Thousands::mark);
    found.file.thousands = thousands.map(|mark| char::from(mark).to_string());
    each_row(&mut |cells| {
        found.rows += 1;
        for (at, column) in found.columns.iter_mut().enumerate() {
            let cell = cells.get(at);
            let cell = thousands.map_or(cell.into(), |mark| without_groups(cell, mark));
            column.take(&cell, layout.is_decimal_comma);
        }
    });
    if layout.is_decimal_comma && found.columns.iter().any(|column| column.has_comma) {
        found.file.decimal = Some(",".to_owned());
    }
    Ok(found)
}

/// Names of columns by their numbers in a comment: `2  3 Motor voltage [V] left, right: 0.0 0.0`.
fn numbered(comment: &str) -> Vec<(usize, String)> {
    let mut rest = comment.trim();
    let mut numbers: Vec<usize> = Vec::new();
    while let Some((word, after)) = rest.split_once(char::is_whitespace)
        && let Ok(number) = word.parse()
    {
        numbers.push(number);
        rest = after.trim_start();
    }
    let is_list = numbers.windows(2).all(|pair| pair[1] == pair[0] + 1);
    if numbers.is_empty() || !is_list || !rest.starts_with(char::is_alphabetic) {
        return Vec::new();
    }
    let text = rest.split(':').next().unwrap_or(rest).trim();
    let (base, parts) = match text.split_once(']') {
        Some((base, parts)) => (format!("{base}]"), parts),
        None => (text.to_owned(), ""),
    };
    let parts: Vec<&str> = parts.split(',').map(str::trim).collect();
    let name = |(k, number): (usize, usize)| {
        let part = match parts.get(k) {
            Some(part) if parts.len() == numbers.len() => *part,
            _ => "",
        };
        (number, format!("{base} {part}").trim().to_owned())
    };
    numbers.iter().copied().enumerate().map(name).collect()
}

fn lines_of(head: &[u8], is_whole: bool) -> Vec<Numbered> {
    let mut found = Vec::new();
    let Ok(mut lines) = lines(head) else {
        return found;
    };
    // A truncated compressed file ends the survey, and is read completely by the import.
    while let Ok(Some(line)) = lines.next() {
        if let Line::Whole(line) = line {
            let line = line.to_vec();
            found.push((lines.number(), line));
        }
        if found.len() >= ROWS + BANNER_LINES {
            return found;
        }
    }
    if !is_whole && !lines.ended() {
        found.pop();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(survey: &Survey) -> Vec<&str> {
        survey
            .columns
            .iter()
            .map(|column| column.name.as_deref().unwrap_or("-"))
            .collect()
    }

    #[test]
    fn layouts_of_many_kinds_are_found() {
        for (log, expected, skip, units, delimiter) in [
            ("t,n\n0,5\n3,6\n6,9\n", vec!["t", "n"], 0, 0, ","),
            (
                "Scope 3\n\nt,n\nms,-\n0,5\n3,6\n6,9\n",
                vec!["t", "n"],
                2,
                1,
                ",",
            ),
            ("t;n\n0,0;5\n3,0;6\n6,0;9\n", vec!["t", "n"], 0, 0, ";"),
            ("0 5\n3 6\n6 9\n", vec!["-", "-"], 0, 0, "space"),
            (
                "# t_ms n\n0 5\n3 6\n6 9\n",
                vec!["t_ms", "n"],
                0,
                0,
                "space",
            ),
            (
                "t\tn\t\r\n0\t5\t\r\n3\t6\t\r\n6\t9\t\r\n",
                vec!["t", "n"],
                0,
                0,
                "tab",
            ),
            (
                "t, n, d\n0, 5, up\n3, 6, up\n6, 9, up\n",
                vec!["t", "n", "d"],
                0,
                0,
                ",",
            ),
            (
                "12:34:56.7 -> t,n\n12:34:56.8 -> 0,5\n12:34:56.9 -> 3,6\n12:34:57.0 -> 6,9\n",
                vec!["-", "t", "n"],
                0,
                0,
                ",",
            ),
            (
                "t,n\n12:34:56.8 -> 0,5\n12:34:56.9 -> 3,6\n12:34:57.0 -> 6,9\n",
                vec!["-", "t", "n"],
                1,
                0,
                ",",
            ),
        ] {
            let survey = survey(log.as_bytes(), true).unwrap_or_else(|_| panic!("{log}"));
            assert_eq!(names(&survey), expected, "{log}");
            assert_eq!(survey.file.skip_lines, skip, "{log}");
            assert_eq!(survey.file.unit_lines, units, "{log}");
            assert_eq!(survey.file.delimiter.as_deref(), Some(delimiter), "{log}");
            assert_eq!(survey.rows, 3, "{log}");
        }
    }

    #[test]
    fn a_text_without_numbers_is_no_table() {
        assert!(survey(b"Dear reader,\nthis is a letter,\nand no log\n", true).is_err());
        assert!(survey(b"", true).is_err());
    }
}
