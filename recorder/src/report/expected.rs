//! What a channel must hold to be reported, or the version that wrote it is asked for.

use std::path::Path;

use mcap::Channel;

use super::ReportError;
use crate::replay::facts::unknown_fields;
use crate::wire::schema::{
    self, GROUND_TRUTH, GUIDE, GUIDE_SCHEMA, IDENTITY, IDENTITY_SCHEMA, IMAGE_SCHEMA, LOG, LOG_SCHEMA, POSE_SCHEMA,
    STATUS, STATUS_SCHEMA, TISSUE, TISSUE_SCHEMA, TOOL_POSE, VIEW, WORKFLOW, WORKFLOW_SCHEMA,
};

/// The schema of a topic that a report tells of.
fn expected(topic: &str) -> Option<&'static str> {
    Some(match topic {
        TOOL_POSE | GROUND_TRUTH => POSE_SCHEMA,
        GUIDE => GUIDE_SCHEMA,
        WORKFLOW => WORKFLOW_SCHEMA,
        STATUS => STATUS_SCHEMA,
        LOG => LOG_SCHEMA,
        TISSUE => TISSUE_SCHEMA,
        IDENTITY => IDENTITY_SCHEMA,
        _ if topic.starts_with(VIEW) => IMAGE_SCHEMA,
        _ => return None,
    })
}

/// Whether a report tells of the topic.
pub(super) fn is_told(topic: &str) -> bool {
    expected(topic).is_some()
}

/// Refuses a channel whose messages would be reported wrongly, or in part.
///
/// # Errors
/// [`ReportError::Schema`], [`ReportError::Newer`].
pub(super) fn check(path: &Path, channel: &Channel<'_>) -> Result<(), ReportError> {
    let topic = &channel.topic;
    let Some(wanted) = expected(topic) else { return Ok(()) };
    let found = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
    if found != wanted {
        return Err(ReportError::Schema {
            path: path.to_owned(),
            topic: topic.clone(),
            found: found.to_owned(),
            wanted,
        });
    }
    let (identity, _) = schema::identity();
    let mut known = schema::schemas().into_iter().chain([identity]);
    let known = known
        .find(|(_, name, _)| *name == wanted)
        .map_or(&[][..], |(.., data)| data);
    // Foxglove's schemas are others' to extend.
    let unknown = match wanted.starts_with("trocar.") {
        true => unknown_fields(channel, known),
        false => String::new(),
    };
    match unknown.is_empty() {
        true => Ok(()),
        false => Err(ReportError::Newer {
            path: path.to_owned(),
            topic: topic.clone(),
            unknown,
        }),
    }
}
