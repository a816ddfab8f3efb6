//! Out of step: silence, then VER, until its text comes.

use super::super::setup::{Step, VERSION};
use super::super::{Action, Notice, Reason};
use super::{Came, Client, Stage, not_an_answer};
use crate::answer::Answer;

impl Client {
    /// Nobody knows any more what answers what.
    pub(super) fn lose_step(&mut self, notice: Notice, now_ns: i64, actions: &mut Vec<Action>) {
        actions.push(Action::Tell(notice));
        self.asked = None;
        self.decoder.restart();
        let began_ns = now_ns;
        let heard_ns = now_ns;
        self.stage = Stage::Quiet { began_ns, heard_ns };
    }

    pub(super) fn quiet(&mut self, began_ns: i64, heard_ns: i64, now_ns: i64, actions: &mut Vec<Action>) {
        let limit = self.rules.quiet_limit_ns;
        if now_ns.saturating_sub(heard_ns) >= self.rules.quiet_ns {
            if self.tries >= self.rules.most_tries {
                let tries = self.tries;
                return self.close(Reason::NoAnswer { tries }, actions);
            }
            self.tries += 1;
            self.stage = Stage::Verifying;
            self.ask(VERSION, now_ns, actions);
        } else if now_ns.saturating_sub(began_ns) > limit {
            self.close(Reason::NeverQuiet { ns: limit }, actions);
        }
    }

    pub(super) fn verified(&mut self, came: Came, now_ns: i64, actions: &mut Vec<Action>) {
        let fits = match (&came, &self.version) {
            (Came::Text(text, Answer::Words(_)), Some(version)) => text == version,
            // The device had not said it yet. Lists and handles have digits alone; whatever is there, the set-up begins
            // anew, at a command that frees all.
            (Came::Text(text, Answer::Words(_)), None) => text.chars().any(|c| c.is_ascii_lowercase()),
            _ => false,
        };
        if !fits {
            return self.lose_step(not_an_answer(&VERSION), now_ns, actions);
        }
        actions.push(Action::Tell(Notice::InStep { tries: self.tries }));
        self.tries = 0;
        if self.was_tracking {
            self.stage = Stage::Tracking;
            self.poll_now(now_ns, actions);
        } else {
            self.set_up(Step::Stop, now_ns, actions);
        }
    }
}
