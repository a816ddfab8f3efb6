//! What goes on: nothing, a hand on its way, a step that listens, or what is computed of it.

use std::rc::Rc;

use bus::message::{Practice, StepMotion, StepPhase, StepTask, StepWish, Steps};

use super::course::{Around, Course, Moment, Proposal, Report, Said, in_a_terminal};
use super::tasks::{begin, tasks};
use crate::live::Heard;

/// What the process is to do.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Todo {
    /// Send the simulated hand there.
    Send(Practice),
    /// Start the command with these words.
    Start(Vec<String>),
    /// End the command that goes on.
    Cancel,
    /// Write this file, and tell [`Desk::written`].
    Write(Proposal),
    /// Tell the pilot.
    Report(Report),
}

/// Why touches are gone.
const MOVED: &str = "the marker on the patient was moved: what was touched before is forgotten; touch all points again";

/// Where a person stands, and what goes on.
pub(super) struct Desk {
    around: Rc<Around>,
    task: Option<(StepTask, Box<dyn Course>)>,
    phase: StepPhase,
    /// The words of the command that goes on, or went on last.
    words: Vec<String>,
    heard: Option<Heard>,
    /// Which step a result is of, and what its motion covers.
    covered: Option<(u32, StepMotion)>,
    refused: String,
}

impl Desk {
    pub(super) fn new(around: Around) -> Self {
        Self {
            around: Rc::new(around),
            task: None,
            phase: StepPhase::Waiting,
            words: Vec::new(),
            heard: None,
            covered: None,
            refused: String::new(),
        }
    }

    /// Carries out what a person wishes: what is to be done for it, and the words of the answer.
    ///
    /// # Errors
    /// Why it cannot be done, in words.
    pub(super) fn wish(&mut self, wish: StepWish) -> Result<(String, Vec<Todo>), String> {
        if let StepWish::Open(task) = wish {
            return self.open(task);
        }
        if wish == StepWish::Cancel {
            return self.cancel();
        }
        if self.phase.is_busy() {
            return Err("a step goes on; give it up first".to_owned());
        }
        let (_, course) = self.task.as_mut().ok_or("no task was begun")?;
        self.refused.clear();
        match wish {
            StepWish::Begin => {
                let listen = course.listen()?;
                (self.words, self.heard, self.covered) = (listen.words.clone(), None, None);
                Ok(match listen.practice {
                    Some(practice) => {
                        self.phase = StepPhase::Going;
                        ("the hand is on its way".to_owned(), vec![Todo::Send(practice)])
                    }
                    None => {
                        self.phase = StepPhase::Listening;
                        ("listening".to_owned(), vec![Todo::Start(listen.words)])
                    }
                })
            }
            StepWish::Back if course.back() => {
                self.covered = None;
                let todo = self.compute()?;
                Ok(("taken back".to_owned(), todo))
            }
            StepWish::Back => Err("there is nothing to take back".to_owned()),
            StepWish::Point(point) if course.choose(point as usize) => Ok(("chosen".to_owned(), Vec::new())),
            StepWish::Point(point) => Err(format!("there is no point {point} to be chosen")),
            StepWish::Accept => {
                let proposal = course.proposal()?;
                let words = format!("accepted into {}", proposal.path.display());
                Ok((words, vec![Todo::Write(proposal)]))
            }
            StepWish::Open(_) | StepWish::Cancel => Err(String::new()),
        }
    }

    fn open(&mut self, task: StepTask) -> Result<(String, Vec<Todo>), String> {
        let course = begin(task, &self.around)?;
        let todo = if self.phase.is_busy() {
            vec![Todo::Cancel]
        } else {
            Vec::new()
        };
        (self.task, self.phase) = (Some((task, course)), StepPhase::Waiting);
        (self.heard, self.covered) = (None, None);
        self.refused.clear();
        Ok((format!("{} is begun", task.word()), todo))
    }

    fn cancel(&mut self) -> Result<(String, Vec<Todo>), String> {
        match self.phase {
            StepPhase::Going | StepPhase::Listening => {
                self.phase = StepPhase::Waiting;
                Ok(("given up".to_owned(), vec![Todo::Cancel]))
            }
            _ => Err("nothing goes on that could be given up".to_owned()),
        }
    }

    /// The hand is there.
    pub(super) fn arrived(&mut self) -> Option<Todo> {
        (self.phase == StepPhase::Going).then(|| {
            self.phase = StepPhase::Listening;
            Todo::Start(self.words.clone())
        })
    }

    /// What the step that listens has heard so far.
    pub(super) fn hears(&mut self, heard: Heard) {
        self.heard = Some(heard);
    }

    /// The marker on the patient was moved: what was touched before says nothing of where she is now.
    pub(super) fn moved(&mut self) -> Vec<Todo> {
        let task = self.task.as_ref().map(|(task, _)| *task);
        let Some(task) = task.filter(|task| matches!(task, StepTask::Register | StepTask::Check)) else {
            return Vec::new();
        };
        let todo = match self.phase.is_busy() {
            true => vec![Todo::Cancel],
            false => Vec::new(),
        };
        (self.phase, self.heard, self.refused) = (StepPhase::Waiting, None, MOVED.to_owned());
        match begin(task, &self.around) {
            Ok(course) => self.task = Some((task, course)),
            Err(why) => (self.task, self.refused) = (None, why),
        }
        todo
    }

    /// Something could not be done, in words.
    pub(super) fn failed(&mut self, why: String) {
        (self.phase, self.refused) = (StepPhase::Waiting, why);
    }

    /// A command has ended.
    pub(super) fn said(&mut self, said: Said, moment: Moment) -> Vec<Todo> {
        let Some((_, course)) = &mut self.task else {
            return Vec::new();
        };
        let done = match self.phase {
            StepPhase::Listening => {
                // The last that was heard of a motion is of the poses that its result is made of.
                let motion = self.heard.take().and_then(|heard| heard.motion);
                let step = course.show(Steps::none(&[])).step;
                let done = course.heard(said, moment);
                self.covered = motion.filter(|_| done.is_ok()).map(|motion| (step, motion));
                done
            }
            StepPhase::Working => course.computed(said),
            // It was given up.
            _ => return Vec::new(),
        };
        self.phase = StepPhase::Waiting;
        let report = course.report().map(Todo::Report);
        let next = done.and_then(|()| self.compute());
        let mut todo: Vec<Todo> = report.into_iter().collect();
        match next {
            Ok(next) => todo.extend(next),
            Err(why) => self.failed(why),
        }
        todo
    }

    fn compute(&mut self) -> Result<Vec<Todo>, String> {
        let Some((_, course)) = &mut self.task else {
            return Ok(Vec::new());
        };
        let words = course.compute()?;
        if words.is_some() {
            self.phase = StepPhase::Working;
        }
        Ok(words.map(Todo::Start).into_iter().collect())
    }

    /// What was accepted was written.
    pub(super) fn written(&mut self) {
        self.phase = StepPhase::Done;
    }

    /// What is shown at `t_ns` of the session's clock.
    pub(super) fn show(&self, t_ns: i64) -> Steps {
        let mut steps = Steps {
            t_ns,
            phase: self.phase.code(),
            refused: Steps::field(&self.refused),
            ..Steps::none(&tasks(&self.around.spec))
        };
        if self.around.room.is_some() {
            steps.flags |= Steps::PRACTICE;
        }
        let Some((task, course)) = &self.task else { return steps };
        steps.task = task.code();
        let mut steps = course.show(steps);
        if let Some(heard) = self.heard.as_ref().filter(|_| self.phase == StepPhase::Listening) {
            (steps.passed_s, steps.asked_s) = (heard.passed_s, heard.asked_s);
            (steps.frames, steps.poses) = (heard.frames as u32, heard.poses as u32);
            steps.advice = Steps::field(&heard.advice);
            steps.motion = heard.motion.unwrap_or(StepMotion::NONE);
        }
        // Another step than the result's has a motion of its own.
        let covered = self.covered.filter(|(step, _)| *step == steps.step);
        if let Some((_, motion)) = covered.filter(|_| !matches!(self.phase, StepPhase::Going | StepPhase::Listening)) {
            steps.motion = motion;
        }
        if !self.phase.is_busy() {
            self.what_can_be_done(course.as_ref(), &mut steps);
        }
        steps
    }

    fn what_can_be_done(&self, course: &dyn Course, steps: &mut Steps) {
        match course.listen() {
            Ok(listen) => {
                steps.flags |= Steps::CAN_BEGIN;
                steps.command = Steps::field(&in_a_terminal(&listen.words));
            }
            Err(why) => steps.why_not = Steps::field(&why),
        }
        match course.proposal() {
            Ok(_) => steps.flags |= Steps::CAN_ACCEPT,
            Err(why) => steps.why_not = Steps::field(&why),
        }
        if steps.step > 0 || steps.counts[2] > 0 {
            steps.flags |= Steps::CAN_GO_BACK;
        }
    }
}
