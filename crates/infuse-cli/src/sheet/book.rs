//! A sheet for the rig as a workbook: what is to be filled in is free, the rest is locked.

use anyhow::{Context as _, Result};
use infuse::pooled::Trial;
use rust_xlsxwriter::{
    DataValidation, DataValidationRule, DocProperties, ExcelDateTime, Format, FormatBorder, Note, Workbook, Worksheet,
    XlsxError,
};

use super::columns::Columns;
use super::read::made_range;
use super::table::Column;
use crate::number::{plain, rounded, with_unit};
use crate::problem::{Held, Problem, Response, Scale};

/// Free rows below those asked for, for further runs.
const FURTHER: usize = 50;
/// Beyond what any value may be, for spreadsheets.
const LARGEST: f64 = 1e100;

/// The bytes of the workbook, the same for the same trials.
pub(super) fn bytes(problem: &Problem, trials: &[(Trial, Option<u64>)]) -> Result<Vec<u8>> {
    let mut book = Workbook::new();
    written(&mut book, problem, trials).and_then(|()| book.save_to_buffer()).context("a workbook")
}

fn written(book: &mut Workbook, problem: &Problem, trials: &[(Trial, Option<u64>)]) -> Result<(), XlsxError> {
    // No clock: the same sheet has the same bytes.
    let properties = DocProperties::new().set_title(problem.title.chars().take(200).collect::<String>());
    book.set_properties(&properties.set_creation_datetime(&ExcelDateTime::from_ymd(2000, 1, 1)?));
    let columns = Columns::of(problem);
    let sheet = book.add_worksheet().set_name("sheet")?;
    let [heading, locked, free, text] = formats();
    for (column, at) in columns.all.iter().zip(0_u16..) {
        sheet.write_string_with_format(0, at, column.heading(), &heading)?;
        sheet.insert_note(
            0,
            at,
            &Note::new(hint(usize::from(at), column, &columns, problem)).set_width(260).set_height(110),
        )?;
        sheet.set_column_width(at, (column.heading().chars().count() as f64 + 3.0).clamp(8.0, 60.0))?;
    }
    for ((trial, repeats), row) in trials.iter().zip(1_u32..) {
        sheet.write_number_with_format(row, place(Columns::RUN), f64::from(row), &locked)?;
        sheet.write_number_with_format(row, place(Columns::ID), trial.id.number() as f64, &locked)?;
        match repeats {
            Some(id) => sheet.write_number_with_format(row, place(Columns::REPEATS), *id as f64, &locked)?,
            None => sheet.write_blank(row, place(Columns::REPEATS), &locked)?,
        };
        for (index, (parameter, &value)) in problem.region.parameters().iter().zip(&trial.point).enumerate() {
            let at = place(columns.setting(index));
            match parameter.choice(value) {
                Some(choice) => sheet.write_string_with_format(row, at, choice, &locked)?,
                None => sheet.write_number_with_format(row, at, rounded(value), &locked)?,
            };
        }
    }
    let n = u32::try_from(trials.len()).unwrap_or(u32::MAX - 1);
    for column in columns.response()..columns.all.len() {
        let is_text = column == columns.failed() || column == columns.note();
        for row in 1..=n {
            sheet.write_blank(row, place(column), if is_text { &text } else { &free })?;
        }
    }
    let last = n + FURTHER as u32;
    for row in n + 1..=last {
        sheet.write_blank(row, place(Columns::REPEATS), &free)?;
        for column in columns.response()..columns.all.len() {
            sheet.write_blank(
                row,
                place(column),
                if column == columns.failed() || column == columns.note() { &text } else { &free },
            )?;
        }
    }
    validate(sheet, problem, &columns, last)?;
    sheet.set_freeze_panes(1, 2)?.protect();
    sheet.set_selection(1, place(columns.response()), 1, place(columns.response()))?;
    sheet.set_landscape().set_repeat_rows(0, 0)?.set_print_fit_to_pages(1, 0);
    Ok(())
}

/// Of headings, of what is locked, of numbers and of texts to be filled in.
fn formats() -> [Format; 4] {
    let free = Format::new()
        .set_unlocked()
        .set_background_color(0xFF_F9_E5)
        .set_border(FormatBorder::Thin)
        .set_border_color(0xC8_C8_C8);
    let heading = Format::new().set_bold().set_text_wrap().set_background_color(0xE6_E6_E6);
    // As text, so that nothing of a remark becomes a date.
    [heading, Format::new().set_font_color(0x40_40_40), free.clone(), free.set_num_format("@")]
}

#[expect(clippy::cast_possible_truncation, reason = "a spreadsheet has fewer columns, and its writer checks that")]
fn place(column: usize) -> u16 {
    column as u16
}

/// What is allowed in the cells that are free.
fn validate(sheet: &mut Worksheet, problem: &Problem, columns: &Columns, last: u32) -> Result<(), XlsxError> {
    let Response { lower, upper, scale, .. } = &problem.response;
    let least = match scale {
        Scale::Linear => -LARGEST,
        Scale::Log => 1.0 / LARGEST,
    };
    let (low, high) = (lower.map_or(least, |lower| lower.max(least)), upper.unwrap_or(LARGEST));
    let range = match (lower, upper) {
        (None | Some(..=0.0), None) if *scale == Scale::Log => "a number above 0".to_owned(),
        (None, None) => "a number".to_owned(),
        (Some(lower), None) => format!("a number from {}", plain(*lower)),
        (None, Some(upper)) => format!("a number up to {}", plain(*upper)),
        (Some(lower), Some(upper)) => format!("a number from {} to {}", plain(*lower), plain(*upper)),
    };
    let at = place(columns.response());
    let unit = &problem.response.unit;
    let expected = format!("{}. A run without a value gets a reason under `failed`.", with_unit(&range, unit));
    sheet.add_data_validation(1, at, last, at, &number(low, high, &expected)?)?;
    for (index, held) in problem.constraints.iter().enumerate() {
        let at = place(columns.constrained(index));
        let expected = format!("{}; empty, if it was not measured.", with_unit("a number", &held.unit));
        sheet.add_data_validation(1, at, last, at, &number(-LARGEST, LARGEST, &expected)?)?;
    }
    for (index, parameter) in problem.region.parameters().iter().enumerate() {
        let at = place(columns.actual(index));
        if let Some(choices) = parameter.choices() {
            // Spreadsheets take lists of so many characters.
            if choices.iter().map(|choice| choice.chars().count() + 1).sum::<usize>() <= 255 {
                let list = DataValidation::new().allow_list_strings(choices)?;
                sheet.add_data_validation(1, at, last, at, &list)?;
            }
            continue;
        }
        let (low, high) = made_range(parameter);
        let range = format!("{} to {}", plain(low), with_unit(&plain(high), parameter.unit()));
        sheet.add_data_validation(1, at, last, at, &number(low, high, &format!("a number from {range}."))?)?;
    }
    let at = place(Columns::REPEATS);
    let rule = DataValidationRule::GreaterThan(0);
    let id = DataValidation::new()
        .allow_whole_number(rule)
        .set_error_message("Expected the id of the experiment that is run once more.")?;
    sheet.add_data_validation(last - FURTHER as u32 + 1, at, last, at, &id)?;
    Ok(())
}

fn number(low: f64, high: f64, expected: &str) -> Result<DataValidation, XlsxError> {
    let rule = DataValidationRule::Between(low, high);
    // Spreadsheets show no more.
    let message: String = format!("Expected {expected}").chars().take(225).collect();
    DataValidation::new().allow_decimal_number(rule).set_error_title("Not possible")?.set_error_message(message)
}

/// What stands in a column, and what is to be filled in.
fn hint(at: usize, column: &Column, columns: &Columns, problem: &Problem) -> String {
    let parameters = problem.region.parameters();
    if let Some(held) = constraint(at, columns, problem) {
        let bounds = held.bounds();
        return format!(
            "Fill in what was measured of it; {bounds} is asked for. If it was not measured, leave it empty."
        );
    }
    match at {
        Columns::RUN => "The order in which to run.".to_owned(),
        Columns::ID => "The number of the experiment, by which its result is found.".to_owned(),
        Columns::REPEATS => {
            "This run repeats that experiment on purpose. For one more run of an experiment, put its id here in a free row below; \
             `id` stays empty."
                .to_owned()
        }
        _ if at == columns.response() => format!(
            "Fill in what was measured{}. If there is none, leave it empty and say why under `failed`.",
            if column.unit.is_empty() { String::new() } else { format!(", in {}", column.unit) }
        ),
        _ if at == columns.failed() => "Only if there is no value: why.".to_owned(),
        _ if at == columns.note() => "Anything worth remembering.".to_owned(),
        _ => match (0..parameters.len()).find(|&index| columns.actual(index) == at) {
            Some(index) if parameters[index].choices().is_some() => {
                "Only if another choice was made than the one asked for: which.".to_owned()
            }
            Some(index) => {
                let (parameter, (low, high)) = (&parameters[index], made_range(&parameters[index]));
                format!(
                    "Only if another setting was made than the one asked for: which. Asked for are {} to {}; taken are {} to {}.",
                    plain(parameter.lower()),
                    with_unit(&plain(parameter.upper()), parameter.unit()),
                    plain(low),
                    with_unit(&plain(high), parameter.unit())
                )
            }
            None => format!(
                "The setting to be made. It is not to be changed: one that was made otherwise goes under `actual {}`.",
                column.name
            ),
        },
    }
}

/// The constraint whose column this is.
fn constraint<'a>(at: usize, columns: &Columns, problem: &'a Problem) -> Option<&'a Held> {
    (0..problem.constraints.len())
        .find(|&index| columns.constrained(index) == at)
        .map(|index| &problem.constraints[index])
}
