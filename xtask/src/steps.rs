//! The steps of a chore: each with its name and the time it took.

use std::time::{Duration, Instant};

use crate::failure::Failure;
use crate::shell::say;

/// The steps that were done.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    done: Vec<(&'static str, Duration)>,
}

impl Steps {
    /// Does a step and says how long it took.
    ///
    /// # Errors
    /// [`Failure::Step`] with the reason of `work`.
    pub(crate) fn step<T>(
        &mut self,
        name: &'static str,
        work: impl FnOnce() -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        say(&format!("=== {name}"));
        let began = now();
        let result = work();
        let took = began.elapsed();
        match result {
            Ok(value) => {
                say(&format!("=== {name}: done, {}", seconds(took)));
                self.done.push((name, took));
                Ok(value)
            }
            Err(failure) => {
                say(&format!("=== {name}: FAILED after {}", seconds(took)));
                let source = Box::new(failure);
                Err(Failure::Step { name, source })
            }
        }
    }

    /// All steps in one line.
    pub(crate) fn summary(&self) -> String {
        let steps: Vec<_> = self
            .done
            .iter()
            .map(|(name, took)| format!("{name} {}", seconds(*took)))
            .collect();
        let total = self.done.iter().map(|(_, took)| *took).sum();
        format!(
            "all {} steps passed in {}: {}",
            steps.len(),
            seconds(total),
            steps.join(", ")
        )
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "a chore's duration is for people and never reaches a bus"
)]
fn now() -> Instant {
    Instant::now()
}

fn seconds(time: Duration) -> String {
    format!("{:.1} s", time.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_step_is_named_and_does_not_count_as_done() {
        let mut steps = Steps::default();
        assert_eq!(steps.step("one", || Ok(7)).ok(), Some(7));
        let failed = steps.step::<()>("two", || Err(Failure::Usage("no".to_owned())));
        assert_eq!(failed.unwrap_err().to_string(), "step \"two\" failed: no");
        assert!(steps.summary().starts_with("all 1 steps passed in "));
    }
}
