//! Flags together with a mapping file: each replaces an entry of the file.

use super::super::map_command::CommandSection;
use super::super::map_file::{FieldSection, MapFile, PositionSection, SpeedSection, TimeSection};
use super::command::LIMIT_OF_A_SUM;
use super::direction::backwards;
use super::given::{GivenColumn, GivenFlags, Steps, expected, number_and_rest};
use super::names::name_facts;
use super::sum::Sum;
use super::units::Role;
use super::{NO_SPEED, Ready, Unclear};

/// The mapping of a mapping file's text with the given replacements; and its text.
/// # Errors
/// A flag is invalid, or the result is no valid mapping.
pub fn map_over(text: &str, given: &GivenFlags) -> Result<Ready, Unclear> {
    let mut map = MapFile::parse(text)?;
    if let Some(text) = &given.time {
        let (column, unit) = column("--time", Role::Time, text)?;
        map.time = Some(TimeSection::of(column.column_ref(), unit));
    }
    if given.command_limit.is_some()
        && !given
            .command
            .as_ref()
            .is_some_and(|text| text.contains('*'))
    {
        return Err(Unclear::Conflict(LIMIT_OF_A_SUM));
    }
    if let Some(text) = &given.command {
        map.command = Some(command(text, given)?);
    } else if let (Some(command), Some(full)) = (&mut map.command, given.pwm_full) {
        command.full = Some(full);
    }
    if let Some(text) = &given.direction {
        let wrong = || Unclear::Form {
            flag: "--direction",
            text: text.clone(),
            expected: "beside a mapping a column and the number or word in it that is backwards, such as dir:0",
        };
        let (name, reverse) = text.rsplit_once(':').ok_or_else(wrong)?;
        let column = name.trim().to_owned();
        if let Some(command) = &mut map.command {
            command.direction = Some(GivenColumn { column, unit: None }.column_ref());
            command.reverse = Some(backwards(reverse));
        }
    }
    if let Some(text) = &given.position {
        let (column, unit) = column("--position", Role::Position, text)?;
        map.speed = None;
        map.position = Some(PositionSection {
            column: Some(column.column_ref()),
            unit: Some(unit.to_owned()),
            ..PositionSection::default()
        });
    }
    if let Some(text) = &given.speed {
        let (column, unit) = column("--speed", Role::Speed, text)?;
        map.position = None;
        map.speed = Some(SpeedSection {
            column: column.column_ref(),
            unit: unit.to_owned(),
            scale: None,
            offset: None,
            integrate: Default::default(),
            time_constant_s: None,
            resolution: None,
        });
    }
    match (&mut map.speed, given.integrate) {
        (Some(speed), Some(rule)) => {
            speed.integrate = rule;
            speed.time_constant_s = None;
        }
        (None, Some(_)) => return Err(Unclear::Conflict(NO_SPEED)),
        (_, None) => {}
    }
    if let Some(position) = &mut map.position {
        position.wrap = given.wrap.or(position.wrap);
        position.increments = given.increments.then_some(true).or(position.increments);
    }
    if let Some(text) = &given.current {
        let (column, unit) = column("--current", Role::Current, text)?;
        map.current = Some(FieldSection::of(column.column_ref(), unit));
    }
    if let Some(text) = &given.supply {
        match number_and_rest(text) {
            Some((volts, "" | "V" | "v")) => map.supply_v = Some(volts),
            _ => {
                let (column, unit) = column("--supply", Role::Supply, text)?;
                map.supply = Some(FieldSection::of(column.column_ref(), unit));
            }
        }
    }
    map.counts_per_rev = given.counts_per_rev.unwrap_or(map.counts_per_rev);
    map.m_per_rev = given.m_per_rev.or(map.m_per_rev);
    map.rows.every = given.every.or(map.rows.every);
    map.rows.runs = given.runs.or(map.rows.runs);
    map.rows.unsigned = given.unsigned.or(map.rows.unsigned);
    if given.reverse {
        map.reverse();
    }
    Ready::of(map)
}

fn command(text: &str, given: &GivenFlags) -> Result<CommandSection, Unclear> {
    let full = given.pwm_full;
    if let Some(steps) = Steps::parse(text)? {
        return Ok(CommandSection {
            points: Some(steps.points),
            unit: Some(steps.unit.to_owned()),
            full,
            ..CommandSection::default()
        });
    }
    if text == "none" {
        return Ok(CommandSection {
            recorded: Some(false),
            ..CommandSection::default()
        });
    }
    if let Some(sum) = Sum::parse(text, |_| false)? {
        return sum.section(given.command_limit, |name| {
            let column = name.to_owned();
            Ok(GivenColumn { column, unit: None }.column_ref())
        });
    }
    let (column, unit) = column("--command", Role::Command, text)?;
    Ok(CommandSection {
        column: Some(column.column_ref()),
        unit: Some(unit.to_owned()),
        full,
        ..CommandSection::default()
    })
}

/// A column and its unit, given or in its name.
fn column(
    flag: &'static str,
    role: Role,
    text: &str,
) -> Result<(GivenColumn, &'static str), Unclear> {
    let found = GivenColumn::parse(flag, role, text, |_| false)?;
    let named = || name_facts(&found.column, None);
    let unit = found
        .unit
        .or_else(|| named().unit.filter(|_| named().role == Some(role)));
    match unit {
        Some(unit) => Ok((found, unit)),
        None => Err(Unclear::NoUnit {
            flag,
            column: found.column,
            expected: expected(role),
        }),
    }
}
