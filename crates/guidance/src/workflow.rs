//! The workflow: from an empty run to navigation, with its gates, as a pure function of a state and an event.
//!
//! ```text
//! EMPTY --volume--> LOADED --identity--> CONFIRMED --calibration--> CALIBRATED --registration--> REGISTERED --check--> CHECKED
//!       --start--> NAVIGATING
//! ```
//!
//! [`TABLE`] holds every row; [`in_words`] prints it. Whatever has no row changes nothing and is refused by name. Each stage rests on
//! all before it: a fact that is withdrawn takes the run back to where the fact is needed again, and any change of the volume to
//! EMPTY. A fact that comes too early is refused, not kept: the actions ask for the next fact, and whoever knows it tells it again.
//! What speaks against a registration (bumped, check failed) is kept, whenever it comes, until another registration is told or a
//! check is passed.
//!
//! There is no clock here: ages come with the events. Whoever drives the workflow tells the age of the check
//! ([`Event::CheckAge`]) at least as often as a check may be too old unnoticed; a start names it again.
//!
//! # Research
//!
//! A run whose rules are not strict skips what a person is asked for: the confirmation of the identity, and the check before the
//! start. It does not skip what speaks against it: a rejected volume (from then on each needs a confirmation), a check that failed, a
//! reference that was bumped. Nor does it skip volume, calibration and registration. The state says what was skipped ([`State::skipped`]), and that it is a research run
//! ([`State::is_research`]), which every screen has to say.

mod event;
mod may;
mod state;
mod step;
mod table;
mod when;

pub use event::{Event, Kind, VolumeId};
pub use may::{Activity, MAY, Mark, May, may};
pub use state::{Check, Identity, Rules, RulesError, Skipped, Stage, State};
pub use step::{Action, Want, Why, step};
pub use table::{Row, TABLE, in_words};
pub use when::When;
