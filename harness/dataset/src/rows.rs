//! Turns the rows of files into those of a data set: grouped by run, in time order, complete.

use super::error::{DatasetError, Defect};
use super::in_time::in_time;
use super::package::{Field, Package};
use super::table::{Origin, Rows, left_out};
use identification::dataset::{Column, Dataset, Dimension, Kind, Role, Unit};

/// Makes a data set of all rows, with notices of what was left out or corrected.
pub(super) fn assemble(package: Package, mut rows: Rows) -> Result<Dataset, DatasetError> {
    let mut notices = package.notices.clone();
    notices.extend(ignored(&package.fields));
    for table in &rows.unended {
        let file = package.tables.get(*table).and_then(|table| table.path.file_name());
        let name = file.map_or("a table".into(), |name| name.to_string_lossy());
        notices.push(format!(
            "the last line of {name} has no line break: if the file was cut short, that row may be wrong"
        ));
    }
    let mut order = together(&rows, &mut notices);
    let time = package.fields.iter().position(|field| field.role == Role::Time);
    if let Some(time) = time.filter(|_| package.kind.is_sampled()) {
        in_time(&mut rows, time, &mut order, &mut notices);
    }
    let mut set = Working { package: &package, rows, order };
    set.leave_out_incomplete(&mut notices)?;
    set.check_time()?;
    set.leave_out_single_rows(&mut notices);
    if set.order.is_empty() {
        return Err(DatasetError::new(&set.file(0), Defect::NoRows));
    }
    let (run_of_row, run_labels) = set.runs();
    let columns = set.columns(&mut notices)?;
    let Package { name, kind, drive, constants, .. } = package;
    Ok(Dataset { name, kind, drive, constants, columns, run_of_row, run_labels, notices })
}

fn ignored(fields: &[Field]) -> Option<String> {
    let names = fields.iter().filter(|field| field.role == Role::Ignore);
    let names: Vec<_> = names.map(|field| field.name.as_str()).collect();
    (!names.is_empty()).then(|| format!("not used, as their role is ignore: {}", names.join(", ")))
}

/// The rows that belong to a run, grouped by run, in order of appearance.
fn together(rows: &Rows, notices: &mut Vec<String>) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..rows.runs.len()).filter(|row| rows.runs[*row].is_some()).collect();
    match rows.runs.len() - order.len() {
        0 => {}
        lost => notices.push(format!("{}: of no run", left_out(lost))),
    }
    // Label numbers increase in order of appearance: a decrease means that an earlier run continues.
    if !order.is_sorted_by_key(|row| rows.runs[*row]) {
        order.sort_by_key(|row| rows.runs[*row]);
        notices.push("rows of one run did not lie together and were brought together".to_owned());
    }
    order
}

/// Rows being turned into a data set. `order` selects and sorts them.
struct Working<'a> {
    package: &'a Package,
    rows: Rows,
    order: Vec<usize>,
}

impl Working<'_> {
    fn file(&self, table: usize) -> std::path::PathBuf {
        self.package.tables.get(table).map(|table| table.path.clone()).unwrap_or_default()
    }

    fn error(&self, row: usize, defect: Defect) -> DatasetError {
        let Origin { table, row } = self.rows.origins[row];
        DatasetError::new(&self.file(table), defect).at_row(row)
    }

    /// Indices of the fields with this role.
    fn of_role(&self, role: Role) -> Vec<usize> {
        let fields = self.package.fields.iter().enumerate();
        fields.filter(|(_, field)| field.role == role).map(|(at, _)| at).collect()
    }

    /// Leaves out rows that lack required values other than references. If several axes of a role are measured, one of
    /// them suffices. The counts of a dropped row, if complete, are added to the next row.
    fn leave_out_incomplete(&mut self, notices: &mut Vec<String>) -> Result<(), DatasetError> {
        let mut needed = Vec::new();
        for alternatives in self.package.kind.required() {
            let groups = alternatives.iter().copied();
            let there: Vec<&[Role]> = groups
                .filter(|group| group.iter().all(|role| !self.of_role(*role).is_empty()))
                .collect();
            for role in there.concat() {
                self.check_not_all_missing(role)?;
                if !role.is_reference() && role != Role::Run {
                    needed.push((role, self.of_role(role)));
                }
            }
        }
        let increments = self.increments();
        let columns = &mut self.rows.columns;
        let mut lost = vec![0_usize; needed.len()];
        let mut carried = 0_usize;
        let mut carry: Option<(usize, Vec<f64>)> = None;
        let runs = &self.rows.runs;
        self.order.retain(|row| {
            let run = runs[*row].unwrap_or_default();
            let lacks = needed
                .iter()
                .position(|(_, fields)| fields.iter().all(|field| columns[*field][*row].is_nan()));
            let pending = carry.take().filter(|(of, _)| *of == run);
            let counted: Vec<f64> = increments.iter().map(|at| columns[*at][*row]).collect();
            let whole = counted.iter().all(|count| !count.is_nan());
            let sums = match &pending {
                Some((_, before)) if whole => {
                    counted.iter().zip(before).map(|(count, before)| count + before).collect()
                }
                Some((_, before)) => before.clone(),
                None => counted,
            };
            match lacks {
                None => {
                    if pending.is_some() {
                        carried += 1;
                        for (at, sum) in increments.iter().zip(&sums) {
                            columns[*at][*row] = *sum;
                        }
                    }
                }
                Some(which) => {
                    lost[which] += 1;
                    carry = (whole || pending.is_some()).then_some((run, sums));
                }
            }
            lacks.is_none()
        });
        for ((role, _), lost) in needed.iter().zip(lost).filter(|(_, lost)| *lost > 0) {
            notices.push(format!("{}: {} is missing", left_out(lost), role.name()));
        }
        if carried > 0 && !increments.is_empty() {
            notices.push(format!(
                "increments of rows left out were added to {carried} rows after them"
            ));
        }
        Ok(())
    }

    fn check_not_all_missing(&self, role: Role) -> Result<(), DatasetError> {
        let fields = self.of_role(role);
        let missing = |field: &usize| self.rows.columns[*field].iter().all(|value| value.is_nan());
        if role == Role::Run || self.rows.origins.is_empty() || !fields.iter().all(missing) {
            return Ok(());
        }
        let error = DatasetError::new(&self.file(0), Defect::AllMissing(role));
        let name = fields.first().map(|field| self.package.fields[*field].name.as_str());
        Err(error.in_field(name.unwrap_or_default()))
    }

    /// Columns that count since the previous row.
    fn increments(&self) -> Vec<usize> {
        let counts = |field: &Field| match field.role {
            Role::WheelLeft | Role::WheelRight => field.unit.dimension() == Dimension::Count,
            Role::GyroAngleIncrement => true,
            _ => false,
        };
        let fields = self.package.fields.iter().enumerate();
        fields.filter(|(_, field)| counts(field)).map(|(at, _)| at).collect()
    }

    /// Checks that time increases within a run; two turns or laps may have the same time.
    fn check_time(&self) -> Result<(), DatasetError> {
        let Some(time) = self.of_role(Role::Time).first().copied() else { return Ok(()) };
        let times = &self.rows.columns[time];
        let sampled = self.package.kind.is_sampled();
        let mut last: Option<(usize, f64)> = None;
        for &row in &self.order {
            let (run, now) = (self.rows.runs[row].unwrap_or_default(), times[row]);
            if now.is_nan() {
                continue;
            }
            if let Some((of, before)) = last
                && of == run
                && (now < before || (sampled && now == before))
            {
                let how = if now < before { "runs backwards" } else { "stands still" };
                let run = self.rows.run_labels.known[run].clone();
                let error = self.error(row, Defect::Time { how, run, before, now });
                return Err(error.in_field(&self.package.fields[time].name));
            }
            last = Some((run, now));
        }
        Ok(())
    }

    /// Leaves out runs of a single sample, which show no change over time.
    fn leave_out_single_rows(&mut self, notices: &mut Vec<String>) {
        if !self.package.kind.is_sampled() {
            return;
        }
        let runs = &self.rows.runs;
        let mut rows_of = vec![0_usize; self.rows.run_labels.known.len()];
        for row in &self.order {
            rows_of[runs[*row].unwrap_or_default()] += 1;
        }
        self.order.retain(|row| rows_of[runs[*row].unwrap_or_default()] > 1);
        for (label, _) in
            self.rows.run_labels.known.iter().zip(rows_of).filter(|(_, rows)| *rows == 1)
        {
            notices.push(format!("run {label} is left out: it has one row"));
        }
    }

    /// Run of each row, and the labels of the remaining runs.
    fn runs(&self) -> (Vec<usize>, Vec<String>) {
        let (mut run_of_row, mut labels) = (Vec::with_capacity(self.order.len()), Vec::new());
        let mut last = None;
        for row in &self.order {
            let run = self.rows.runs[*row].unwrap_or_default();
            if last != Some(run) {
                labels.push(self.rows.run_labels.known[run].clone());
                last = Some(run);
            }
            run_of_row.push(labels.len() - 1);
        }
        (run_of_row, labels)
    }

    fn columns(&mut self, notices: &mut Vec<String>) -> Result<Vec<Column>, DatasetError> {
        let mut columns = Vec::new();
        for (at, field) in self.package.fields.iter().enumerate() {
            if matches!(field.role, Role::Run | Role::Ignore) {
                continue;
            }
            let read = std::mem::take(&mut self.rows.columns[at]);
            let mut values: Vec<f64> = self.order.iter().map(|row| read[*row]).collect();
            if field.unit == Unit::Celsius {
                notices.extend(field.scale.convert(&field.name, field.role, &mut values));
            }
            notices.extend(peculiarity(self.package.kind, field, &values));
            if field.text {
                let words = self.rows.words[at].known.len();
                notices
                    .push(format!("{} is text: its {words} words are numbered from 0", field.name));
            }
            let Field { name, role, axis, unit, .. } = field.clone();
            columns.push(Column { name, role, axis, unit, values });
        }
        Ok(columns)
    }
}

/// Notices about a column: missing cells, or a constant value.
fn peculiarity(kind: Kind, field: &Field, values: &[f64]) -> Vec<String> {
    let name = &field.name;
    let mut there = values.iter().filter(|value| !value.is_nan());
    let missing = values.len() - there.clone().count();
    let mut notices = Vec::new();
    match missing {
        0 => {}
        all if all == values.len() => return vec![format!("{name} is empty: no candidate cause")],
        some => notices.push(format!("{name}: {some} of {} cells are missing", values.len())),
    }
    let first = there.next();
    let constant = values.len() > 1 && there.all(|value| Some(value) == first);
    let names_a_cause = !field.role.is_reference()
        && !kind.required().iter().any(|any| any.iter().any(|all| all.contains(&field.role)));
    if constant && names_a_cause {
        notices.push(format!("{name} is constant: no candidate cause"));
    } else if constant && !field.role.is_reference() && field.role != Role::Direction {
        notices.push(format!("{name} is constant"));
    }
    notices
}
