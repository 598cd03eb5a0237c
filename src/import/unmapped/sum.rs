//! A command that is a sum of columns: `2*goal-2*position:V`.

use super::super::map::{ColumnRef, Term};
use super::super::map_command::CommandSection;
use super::unclear::Unclear;
use super::units::{Role, unit_of};

/// Terms and unit, as given.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sum {
    /// Factor and column.
    pub terms: Vec<(f64, String)>,
    pub unit: &'static str,
}

impl Sum {
    /// `None` for a column, or a text without a factor.
    pub fn parse(text: &str, is_column: impl Fn(&str) -> bool) -> Result<Option<Self>, Unclear> {
        if !text.contains('*') || is_column(text) {
            return Ok(None);
        }
        let wrong = || Unclear::Form {
            flag: "--command",
            text: text.to_owned(),
            expected: "such as 2*goal-2*position:V: a factor, * and a column for each term, and the unit of the sum",
        };
        let (mut rest, unit) = text.rsplit_once(':').ok_or_else(wrong)?;
        let unit = unit_of(Role::Command, unit).ok_or_else(wrong)?;
        let mut terms = Vec::new();
        while !rest.trim().is_empty() {
            let (factor, after) = factor(rest).ok_or_else(wrong)?;
            let is_sign = |(at, _): &(usize, char)| factor_at(after, *at);
            let end = after
                .char_indices()
                .find(is_sign)
                .map_or(after.len(), |(at, _)| at);
            let column = after[..end].trim();
            if column.is_empty() || factor == 0.0 {
                return Err(wrong());
            }
            terms.push((factor, column.to_owned()));
            rest = &after[end..];
        }
        Ok(Some(Self { terms, unit }))
    }

    /// Section of a mapping.
    pub fn section(
        &self,
        limit: Option<f64>,
        mut column: impl FnMut(&str) -> Result<ColumnRef, Unclear>,
    ) -> Result<CommandSection, Unclear> {
        let term = |(factor, name): &(f64, String)| {
            Ok(Term {
                column: column(name)?,
                factor: *factor,
            })
        };
        Ok(CommandSection {
            sum: Some(
                self.terms
                    .iter()
                    .map(term)
                    .collect::<Result<_, Unclear>>()?,
            ),
            unit: Some(self.unit.to_owned()),
            limit,
            ..CommandSection::default()
        })
    }
}

/// A factor with its `*`, and the rest.
fn factor(text: &str) -> Option<(f64, &str)> {
    let (number, after) = text.split_once('*')?;
    let number: String = number.chars().filter(|c| !c.is_whitespace()).collect();
    let number: f64 = number.parse().ok()?;
    number.is_finite().then_some((number, after))
}

/// Whether the sign of the next term's factor is here.
fn factor_at(text: &str, at: usize) -> bool {
    let rest = &text[at..];
    rest.starts_with(['+', '-']) && factor(rest).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_factors_and_units_are_read() {
        let parse = |text| Sum::parse(text, |name| name == "a*b");
        for (text, terms) in [
            (
                "2*goal-2*position:V",
                vec![(2.0, "goal"), (-2.0, "position")],
            ),
            (
                "-0.5 * goal + 1e-3*2nd-pos :V",
                vec![(-0.5, "goal"), (1e-3, "2nd-pos")],
            ),
            ("1*a:b:V", vec![(1.0, "a:b")]),
        ] {
            let terms: Vec<(f64, String)> = terms
                .into_iter()
                .map(|(factor, name)| (factor, name.to_owned()))
                .collect();
            assert_eq!(
                parse(text).expect(text),
                Some(Sum { terms, unit: "V" }),
                "{text}"
            );
        }
        for plain in ["pwm", "pwm:V", "a*b"] {
            assert_eq!(parse(plain).expect(plain), None, "{plain}");
        }
        for wrong in [
            "2*goal",
            "goal*2:V",
            "2*:V",
            "0*goal:V",
            "2*goal:furlong",
            "*:V",
        ] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
