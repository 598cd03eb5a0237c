//! `motorlab lab --class FOLDER`: one page over the recordings of a class, one folder per student.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::foreign::unreadable;
use super::motor_file::motor_file;
use super::output_file::{Form, Outputs};
use super::progress::{set_share, spinner};
use super::signals::StopSignal;
use super::{Failure, Output, Status};
use crate::hint::{In, on_one_line};
use crate::lab::Progress;
use crate::lab::class::{Class, Folder, Student};
use crate::lab::class_page::page;
use crate::motor::Motor;
use crate::plain::shown;
use crate::recording::{Run, read_run};

/// A student's motor file.
const MOTOR: &str = "motor.toml";

/// Arguments of the call.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClassRequest<'a> {
    /// The class's folder.
    pub folder: &'a Path,
    /// The motor of all students without a file.
    pub motor: Option<&'a PathBuf>,
    /// Folder of the page.
    pub to: &'a Path,
}

#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    class: &'a Class,
    files: [PathBuf; 2],
}

/// Reads, diagnoses and writes the page; unusable recordings are reported and give exit status 1.
pub(super) fn class(
    asked: ClassRequest<'_>,
    outputs: &Outputs,
    output: &Output,
) -> Result<Status, Failure> {
    let files = ["index.html", "class.json"].map(|name| asked.to.join(name));
    for file in &files {
        outputs.may_replace(file, None)?;
    }
    let folders = folders(asked)?;
    let motor = match asked.motor {
        Some(path) => Some(motor_file(path, output)?),
        None => None,
    };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(Failure::device)?;
    let students = runtime.block_on(all(&folders, motor, output));
    runtime.shutdown_background();
    let mut class = Class {
        shape: "motorlab-class/1",
        folder: shown(asked.folder),
        folders: folders.len(),
        students: students?,
    };
    make(asked.to)?;
    write_pages(&mut class, asked.to, outputs)?;
    outputs.write_silently(&files[0], &page(&class), Form::Markup)?;
    let json = serde_json::to_string_pretty(&class).map_err(Failure::input)?;
    outputs.write_silently(&files[1], &json, Form::Json)?;
    let is_all = class.students.len() == class.folders;
    let is_sound = is_all && class.students.iter().all(Student::is_sound);
    if output.json {
        output.document(&Document {
            class: &class,
            files,
        })?;
    } else {
        if !is_all {
            output.line(&format!(
                "stopped after {} of {} folders; the page has these",
                class.students.len(),
                class.folders
            ))?;
        }
        output.line(&format!("the page: {}", shown(&files[0])))?;
    }
    Ok(match is_sound {
        true => Status::Done,
        false => Status::FellShort,
    })
}

fn make(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder)
        .map_err(|error| Failure::device(In::new(format!("cannot make {}", shown(folder)), error)))
}

/// A page for each recording, in a folder per student.
fn write_pages(class: &mut Class, to: &Path, outputs: &Outputs) -> Result<(), Failure> {
    for student in &mut class.students {
        for recording in &mut student.recordings {
            let Some(page) = recording.page.take() else {
                continue;
            };
            make(&to.join(&student.name))?;
            let file = format!("{}/{}.html", student.name, recording.name);
            outputs.write_silently(&to.join(&file), &page, Form::Markup)?;
            recording.page_file = Some(file);
        }
    }
    Ok(())
}

/// Hint for `--class`.
const ONE_FOLDER_A_STUDENT: &str = "--class takes a folder that has one folder per student";

fn folders(asked: ClassRequest<'_>) -> Result<Vec<PathBuf>, Failure> {
    let cannot = |error: std::io::Error| {
        Failure::wrong(
            format!("{}: {error}", shown(asked.folder)),
            ONE_FOLDER_A_STUDENT,
        )
    };
    let mut folders = Vec::new();
    for entry in fs::read_dir(asked.folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let is_hidden = name_of(&path).starts_with('.');
        let is_page = same(&path, asked.to);
        if path.is_dir() && !is_hidden && !is_page {
            folders.push(path);
        }
    }
    folders.sort();
    if folders.is_empty() {
        return Err(Failure::wrong(
            format!("{} has no folder in it", shown(asked.folder)),
            ONE_FOLDER_A_STUDENT,
        ));
    }
    Ok(folders)
}

fn same(one: &Path, other: &Path) -> bool {
    let whole = (one.canonicalize().ok()).zip(other.canonicalize().ok());
    whole.is_some_and(|(one, other)| one == other)
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// All students; those that are done if Ctrl-C is pressed.
async fn all(
    folders: &[PathBuf],
    motor: Option<Motor>,
    output: &Output,
) -> Result<Vec<Student>, Failure> {
    let stop = StopSignal::install().map_err(Failure::device)?;
    let mut students = Vec::new();
    let bar = spinner();
    for (k, path) in folders.iter().enumerate() {
        let name = name_of(path);
        let place = format!("{name} ({} of {})", k + 1, folders.len());
        bar.set_message(place.clone());
        let folder = read(path, motor.clone(), output);
        let shown = bar.clone();
        let count = folders.len();
        let working = tokio::task::spawn_blocking(move || match folder {
            Ok(folder) => {
                let progress = Progress {
                    doing: &|what: &str| shown.set_message(format!("{place}: {what}")),
                    done: &|share| set_share(&shown, (k as f64 + share) / count as f64),
                };
                Student::of(folder, progress)
            }
            Err(why) => Student::unreadable(name, why),
        });
        let student = tokio::select! {
            student = working => student.map_err(Failure::device)?,
            () = stop.clone().asked() => break,
        };
        let line = format!(
            "{}/{}  {}: {}",
            k + 1,
            folders.len(),
            student.name,
            student.words()
        );
        match output.json {
            true => output.message(&line),
            false => bar.suspend(|| output.line(&line))?,
        }
        students.push(student);
    }
    bar.finish_and_clear();
    Ok(students)
}

/// Content of a student's folder: files `NAME.csv`, and possibly a motor file.
fn read(path: &Path, motor: Option<Motor>, output: &Output) -> Result<Folder, String> {
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(path).map_err(|error| format!("cannot be read: {error}"))? {
        let file = entry
            .map_err(|error| format!("cannot be read: {error}"))?
            .path();
        let is_csv = file
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("csv"));
        if is_csv && file.is_file() && !name_of(&file).starts_with('.') {
            files.push(file);
        }
    }
    files.sort();
    let own = path.join(MOTOR);
    let motor = match (own.exists(), motor) {
        (true, _) => motor_file(&own, output)
            .map(|motor| (motor, true))
            .map_err(|why| on_one_line(&why.to_string())),
        (false, Some(motor)) => Ok((motor, true)),
        (false, None) => Ok((Motor::default(), false)),
    };
    let runs = files
        .iter()
        .map(|file| (name_of(file), run(file)))
        .collect();
    Ok(Folder {
        name: name_of(path),
        motor,
        runs,
    })
}

fn run(file: &Path) -> Result<Run, String> {
    let read = read_run(file).map_err(|error| on_one_line(&unreadable(file, error).to_string()));
    let (run, _) = read?;
    match run.len() {
        0 | 1 => Err(
            "the recording has fewer than two samples; record at least one whole step".to_owned(),
        ),
        _ => Ok(run),
    }
}
