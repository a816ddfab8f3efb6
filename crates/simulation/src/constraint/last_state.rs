//! What was found in the last state that was asked for.

use std::sync::{Arc, Mutex, PoisonError};

/// A value that depends on the state alone, with the state it was found in: energy, gradient and second derivatives ask for
/// the same one after the other. A copy begins empty.
#[derive(Debug)]
pub(super) struct LastState<T>(Mutex<Option<(Vec<f64>, Arc<T>)>>);

impl<T> Default for LastState<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<T> Clone for LastState<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<T> LastState<T> {
    /// The value at `a`: the one that was found there last, or else what `find` returns. Whoever changes what `find` reads
    /// must call [`Self::forget`].
    pub(super) fn at(&self, a: &[f64], find: impl FnOnce() -> T) -> Arc<T> {
        // A thread that died while it looked has left the last value or none: either is whole.
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((known, value)) if known == a => Arc::clone(value),
            _ => {
                let value = Arc::new(find());
                *last = Some((a.to_vec(), Arc::clone(&value)));
                value
            }
        }
    }

    /// Looks anew the next time.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_looked_at_once_until_another_is_or_it_is_forgotten() {
        let (mut last, looks) = (LastState::default(), std::cell::Cell::new(0));
        let at = |last: &LastState<usize>, a: &[f64]| {
            *last.at(a, || {
                looks.set(looks.get() + 1);
                looks.get()
            })
        };
        assert_eq!([at(&last, &[1.0]), at(&last, &[1.0]), at(&last, &[2.0])], [1, 1, 2]);
        assert_eq!([at(&last.clone(), &[2.0]), at(&last, &[2.0])], [3, 2]);
        last.forget();
        assert_eq!(at(&last, &[2.0]), 4);
        // NaN is no state that was seen before.
        assert_eq!([at(&last, &[f64::NAN]), at(&last, &[f64::NAN])], [5, 6]);
    }
}
