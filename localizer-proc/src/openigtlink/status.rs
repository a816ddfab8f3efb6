//! What a peer says of a tool beside its pose, as a reason of the bus: one table.

use bus::message::Lost;
use igtl::ToolStatus;
use scene::localizer::StatusRule;

/// Whether a pose with this status may be used; else the reason that is shown, and what a person must be told of it, where the word alone
/// does not say it.
pub(super) fn judge(status: &ToolStatus, rule: StatusRule) -> Result<(), (Lost, Option<String>)> {
    let told = |lost, words: &str| Err((lost, Some(words.to_owned())));
    match status {
        ToolStatus::Ok => Ok(()),
        ToolStatus::Absent if rule == StatusRule::AbsentMeansValid => Ok(()),
        ToolStatus::Absent => told(
            Lost::Refused,
            "the peer states no status; where it is known to send nothing for a tool that it does not see, the scene says \
             localizer.status = \"absent-means-valid\"",
        ),
        ToolStatus::Missing | ToolStatus::OutOfView => Err((Lost::NotSeen, None)),
        ToolStatus::OutOfVolume => Err((Lost::OutOfVolume, None)),
        ToolStatus::TimedOut => told(
            Lost::Disconnected,
            "the peer's own device does not answer it (REQ_TIMEOUT)",
        ),
        // A button does not make a pose wrong, but its peer says this in the place of OK.
        ToolStatus::SwitchOn(_) => told(Lost::Refused, "the peer states a pressed button in the place of OK"),
        ToolStatus::Invalid => Err((Lost::Refused, None)),
        ToolStatus::PathNotFound => told(
            Lost::Refused,
            "the peer knows no way between the two frames (PATH_NOT_FOUND)",
        ),
        ToolStatus::Unknown => told(Lost::Refused, "the peer states UNKNOWN"),
        ToolStatus::Foreign(word) => Err((
            Lost::Refused,
            Some(format!("the peer states {word:?}, which is not OK")),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_but_ok_is_a_pose_unless_the_scene_says_so() {
        let rows = [
            (ToolStatus::Ok, None, false),
            (ToolStatus::Absent, Some(Lost::Refused), true),
            (ToolStatus::Missing, Some(Lost::NotSeen), false),
            (ToolStatus::OutOfView, Some(Lost::NotSeen), false),
            (ToolStatus::OutOfVolume, Some(Lost::OutOfVolume), false),
            (ToolStatus::SwitchOn(1), Some(Lost::Refused), true),
            (ToolStatus::SwitchOn(2), Some(Lost::Refused), true),
            (ToolStatus::SwitchOn(3), Some(Lost::Refused), true),
            (ToolStatus::TimedOut, Some(Lost::Disconnected), true),
            (ToolStatus::Invalid, Some(Lost::Refused), false),
            (ToolStatus::PathNotFound, Some(Lost::Refused), true),
            (ToolStatus::Unknown, Some(Lost::Refused), true),
            (ToolStatus::Foreign("ok".to_owned()), Some(Lost::Refused), true),
            (ToolStatus::Foreign(String::new()), Some(Lost::Refused), true),
        ];
        for rule in [StatusRule::Required, StatusRule::AbsentMeansValid] {
            for (status, lost, is_told) in &rows {
                let absent = rule == StatusRule::AbsentMeansValid && *status == ToolStatus::Absent;
                let found = judge(status, rule);
                let expected = if absent { None } else { *lost };
                assert_eq!(found.as_ref().err().map(|(lost, _)| *lost), expected, "{status:?}");
                assert_eq!(
                    found.err().is_some_and(|(_, words)| words.is_some()),
                    *is_told && !absent,
                    "{status:?}"
                );
            }
        }
    }
}
