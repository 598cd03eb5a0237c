//! A matrix of counts as a drawing; larger counts are darker.

use std::fmt::Write;

use super::escape::escaped;

/// Counts by row and column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Matrix {
    /// Quantity.
    pub title: String,
    /// Name of the rows.
    pub row_label: String,
    /// Names of the rows, from the top.
    pub column_label: String,
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Counts by row; missing ones are 0.
    pub counts: Vec<Vec<u64>>,
}

const CELL: f64 = 22.0;
const NAMES: f64 = 158.0;
const TITLE: f64 = 30.0;
const LABEL: f64 = 20.0;
/// Width in pixels to which a wide drawing shrinks, and below which a narrow one is not enlarged.
const LEAST: f64 = 576.0;

impl Matrix {
    /// The drawing for an HTML page with [`super::svg::STYLE`]. Cells with equal names of row and column have one
    /// colour, the others another; each cell has its count.
    pub fn inline(&self) -> String {
        let (left, top) = (LABEL + NAMES, TITLE + LABEL + NAMES);
        let width = left + CELL * self.columns.len() as f64 + 8.0;
        let height = top + CELL * self.rows.len() as f64 + 8.0;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\" style=\"min-width:{}px;max-width:{width}px\" role=\"img\" aria-label=\"{}\">\
             <text class=\"title\" x=\"{LABEL}\" y=\"19\">{}</text>\
             <text x=\"{left}\" y=\"{:.1}\">{}</text>\
             <text transform=\"translate(14 {:.1}) rotate(-90)\">{}</text>",
            width.min(LEAST),
            escaped(&self.title),
            escaped(&self.title),
            TITLE + 14.0,
            escaped(&self.column_label),
            height - 8.0,
            escaped(&self.row_label),
        );
        for (k, name) in self.columns.iter().enumerate() {
            let x = left + CELL * (k as f64 + 0.5) + 4.0;
            let _ = write!(
                out,
                "<text class=\"tick\" transform=\"translate({x:.1} {:.1}) rotate(-90)\">{}</text>",
                top - 6.0,
                escaped(name)
            );
        }
        for (r, name) in self.rows.iter().enumerate() {
            let y = top + CELL * r as f64;
            let _ = write!(
                out,
                "<text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 6.0,
                y + CELL / 2.0 + 4.0,
                escaped(name)
            );
            self.draw_row(&mut out, r, left, y);
        }
        out.push_str("</svg>");
        out
    }

    fn draw_row(&self, out: &mut String, r: usize, left: f64, y: f64) {
        let counts = self.counts.get(r).map_or(&[][..], Vec::as_slice);
        let sum = counts.iter().sum::<u64>().max(1) as f64;
        for (c, column) in self.columns.iter().enumerate() {
            let count = counts.get(c).copied().unwrap_or(0);
            let x = left + CELL * c as f64;
            let same = self.rows[r] == *column;
            let colour = if same { 2 } else { 1 };
            let share = count as f64 / sum;
            let opacity = if count == 0 { 0.0 } else { 0.25 + 0.75 * share };
            let _ = write!(
                out,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"var(--c{colour})\" fill-opacity=\"{opacity:.2}\" stroke=\"var(--grid)\"/>"
            );
            if count > 0 {
                let _ = write!(
                    out,
                    "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{count}</text>",
                    x + CELL / 2.0,
                    y + CELL / 2.0 + 4.0
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_count_is_in_its_cell_and_names_are_escaped() {
        let matrix = Matrix {
            rows: vec!["<a>".into(), "b".into()],
            columns: vec!["<a>".into(), "b".into()],
            counts: vec![vec![31, 0], vec![0, 47]],
            ..Matrix::default()
        };
        let svg = matrix.inline();
        let middle = |k: f64, from: f64| from + CELL * (k + 0.5);
        let cell = |c: f64, r: f64, count: u64| {
            format!(
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{count}</text>",
                middle(c, LABEL + NAMES),
                middle(r, TITLE + LABEL + NAMES) + 4.0
            )
        };
        assert!(
            svg.contains(&cell(0.0, 0.0, 31)) && svg.contains(&cell(1.0, 1.0, 47)),
            "{svg}"
        );
        assert!(svg.contains("&lt;a&gt;") && !svg.contains("<a>"));
    }
}
