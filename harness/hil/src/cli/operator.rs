//! Source of answers to a plan's questions: arguments, a file, or a person at the terminal.

use super::failure::Failure;
use super::progress::Screen;
use super::setup::Setup;
use super::terminal::Terminal;
use clap::Args;
use harness::operator::{AnswerFile, Answers, Attendance, GivenAnswer, RealRoles};
use plan::Plan;
use std::path::PathBuf;

/// Answers given before the run, and who gives the others.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct OperatorArguments {
    /// Answer to a question of the plan, such as gap=1.5mm; without a unit, in the unit of the
    /// question.
    #[arg(long = "answer", value_name = "NAME=VALUE")]
    given: Vec<GivenAnswer>,
    /// File of such answers, for unattended runs: TOML with by = "your name" and a table "answers"
    /// of strings such as gap = "1.5 mm".
    #[arg(long, value_name = "FILE")]
    answers: Option<PathBuf>,
    /// Name of the operator at the terminal, for the record. [default: the user's name]
    #[arg(long, value_name = "NAME")]
    operator: Option<String>,
}

impl OperatorArguments {
    /// Returns the answers for `plans`, and the person at the terminal if there is one and the bench is real.
    ///
    /// # Errors
    ///
    /// When an answer cannot be used, or is missing and no person can be asked.
    pub(super) fn collect<'a>(
        &self,
        setup: &Setup,
        plans: impl IntoIterator<Item = &'a Plan>,
        screen: &Screen,
    ) -> Result<(Answers, Option<Terminal>), Failure> {
        let person = match setup {
            Setup::Simulated | Setup::Kernel(_) => None,
            Setup::Live(_) => Terminal::of_stdin(screen, self.operator.as_deref()),
        };
        let attendance = match (setup, &person) {
            (Setup::Simulated | Setup::Kernel(_), _) => Attendance::Simulated,
            (Setup::Live(_), Some(_)) => Attendance::Person,
            (Setup::Live(_), None) => Attendance::Nobody,
        };
        Ok((self.given(setup, plans, attendance)?, person))
    }

    /// Returns the answers for `plans` that run where no person can be asked.
    ///
    /// # Errors
    ///
    /// When an answer cannot be used, or is missing.
    #[cfg(feature = "nats")]
    pub(super) fn collect_for_elsewhere<'a>(
        &self,
        setup: &Setup,
        plans: impl IntoIterator<Item = &'a Plan>,
    ) -> Result<Answers, Failure> {
        self.given(setup, plans, Attendance::Nobody)
    }

    fn given<'a>(
        &self,
        setup: &Setup,
        plans: impl IntoIterator<Item = &'a Plan>,
        attendance: Attendance,
    ) -> Result<Answers, Failure> {
        let path = self.answers.clone().or_else(|| setup.answer_file());
        let file = path.map(|path| AnswerFile::load(&path)).transpose();
        let file = file.map_err(harness::operator::AnswersError::from)?;
        let real = match setup {
            Setup::Simulated | Setup::Kernel(_) => RealRoles::default(),
            Setup::Live(live) => RealRoles::of(&live.bench),
        };
        Ok(Answers::collect(&self.given, file.as_ref(), plans, real, attendance)?)
    }
}
