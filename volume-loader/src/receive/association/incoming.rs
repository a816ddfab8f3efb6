//! One message with a data set: an instance on its way to the disk, or something that is passed over to be refused at its end.

use std::io;

use super::super::command::{Command, Status};
use super::super::contexts::{Class, Context};
use super::super::instance::{self, Ids};
use super::super::limits::Limits;
use super::super::part::Part;
use super::super::store::{PlaceError, Placed, Store};
use super::super::uid::Uid;

/// The room on the disk is asked for again after so many bytes.
const LOOK_BYTES: u64 = 16 << 20;

/// Why an instance is refused: for the peer, and in words.
pub(super) type Refused = (Status, String);

enum State {
    Part(Part, Uid),
    Refused(Refused),
}

/// What is being received.
pub(super) struct Incoming {
    /// The context it came in.
    pub(super) context: u8,
    /// What asked for it.
    pub(super) command: Command,
    /// Whether it is an instance to be stored.
    pub(super) is_instance: bool,
    state: State,
    /// The room on the disk is asked for once there are more bytes.
    look_at: u64,
}

/// What became of an instance.
pub(super) struct Arrived {
    pub(super) context: u8,
    pub(super) command: Command,
    pub(super) is_instance: bool,
    /// What it names itself, once that is known, and whether its series lay among the incomplete ones before.
    pub(super) ids: Option<(Ids, bool)>,
    pub(super) fate: Result<Placed, Refused>,
}

fn out_of(error: io::Error) -> Refused {
    (Status::OutOfResources, format!("it cannot be written: {error}"))
}

impl Incoming {
    /// A data set that nobody wants.
    pub(super) fn unwanted(context: u8, command: Command, refused: Refused) -> Self {
        Self {
            context,
            command,
            is_instance: false,
            state: State::Refused(refused),
            look_at: 0,
        }
    }

    /// An instance of this class and this name, in this context; the association's how manieth it is.
    pub(super) fn instance(
        id: u8,
        command: Command,
        context: &Context,
        announced: [Option<&Uid>; 2],
        (store, limits, number): (&Store, &Limits, u64),
    ) -> Self {
        let state = match begun(context, announced, (store, limits, number)) {
            Ok((part, name)) => State::Part(part, name),
            Err(refused) => State::Refused(refused),
        };
        Self {
            context: id,
            command,
            is_instance: true,
            state,
            look_at: LOOK_BYTES,
        }
    }

    /// More of the data set, of which the association has had `before`. Beyond a limit it is passed over, and nothing of it stays.
    pub(super) fn data(&mut self, bytes: &[u8], store: &Store, limits: &Limits, before: u64) {
        let State::Part(part, _) = &mut self.state else { return };
        let length = part.data() + bytes.len() as u64;
        let beyond = |what: &str, limit: u64| Err((Status::OutOfResources, format!("{what} than {limit} bytes")));
        let mut written = if length > limits.instance_bytes {
            beyond("an instance of more", limits.instance_bytes)
        } else if before + bytes.len() as u64 > limits.association_bytes {
            beyond("an association of more", limits.association_bytes)
        } else {
            part.write(bytes).map_err(out_of)
        };
        if written.is_ok() && length > self.look_at {
            self.look_at = length + LOOK_BYTES;
            written = room(store, limits);
        }
        if let Err(refused) = written {
            self.state = State::Refused(refused);
        }
    }

    /// The data set is at its end.
    pub(super) fn end(self, context: &Context, store: &Store) -> Arrived {
        let (ids, fate) = match self.state {
            State::Refused(refused) => (None, Err(refused)),
            State::Part(part, name) => arrived(part, &name, context, store),
        };
        Arrived {
            context: self.context,
            command: self.command,
            is_instance: self.is_instance,
            ids,
            fate,
        }
    }
}

fn begun(
    context: &Context,
    [class, instance]: [Option<&Uid>; 2],
    (store, limits, number): (&Store, &Limits, u64),
) -> Result<(Part, Uid), Refused> {
    let instance = instance.ok_or_else(|| {
        let why = "its SOP Instance UID is no unique identifier".to_owned();
        (Status::InvalidInstance, why)
    })?;
    if context.class == Class::Verification || class != Some(&context.class_uid) {
        let why = "its SOP Class UID is not that of its presentation context".to_owned();
        return Err((Status::NoMatch, why));
    }
    if number > limits.instances {
        let why = format!("an association of more than {} instances", limits.instances);
        return Err((Status::OutOfResources, why));
    }
    room(store, limits)?;
    let part = Part::create(store.folder(), [&context.class_uid, instance, &context.syntax_uid]).map_err(out_of)?;
    Ok((part, instance.clone()))
}

fn room(store: &Store, limits: &Limits) -> Result<(), Refused> {
    match store.free() {
        Ok(free) if free >= limits.free_bytes => Ok(()),
        Ok(free) => {
            let (free, needed) = (free >> 20, limits.free_bytes >> 20);
            let why = format!("the disk has {free} MiB left, and {needed} MiB are kept free");
            Err((Status::OutOfResources, why))
        }
        Err(error) => Err(out_of(error)),
    }
}

/// An instance that is there to its last byte: looked through, and given its name.
fn arrived(
    mut part: Part,
    name: &Uid,
    context: &Context,
    store: &Store,
) -> (Option<(Ids, bool)>, Result<Placed, Refused>) {
    let (data_at, length) = (part.data_at(), part.data_at() + part.data());
    let file = match part.written() {
        Ok(file) => file,
        Err(error) => return (None, Err(out_of(error))),
    };
    let ids = match instance::examine(file, data_at, length, context.syntax) {
        Ok(ids) => ids,
        Err(instance::InstanceError::Io(error)) => return (None, Err(out_of(error))),
        Err(error) => return (None, Err((Status::NotUnderstood, error.to_string()))),
    };
    let announced = |uid: &Uid, other: &Uid, what: &str| match uid == other {
        true => Ok(()),
        false => Err((
            Status::NoMatch,
            format!("its data set is of another {what} than was announced"),
        )),
    };
    let is_image = matches!(context.class, Class::Slices | Class::Segmentation);
    let checked = announced(&ids.class, &context.class_uid, "SOP class")
        .and_then(|()| announced(&ids.instance, name, "SOP instance"))
        .and_then(|()| match is_image && !ids.has_pixels {
            true => Err((Status::NotUnderstood, instance::InstanceError::Pixels.to_string())),
            false => Ok(()),
        });
    if let Err(refused) = checked {
        // What it names itself is not to be believed.
        return (None, Err(refused));
    }
    let (_, was_hidden) = store.path([&ids.study, &ids.series]);
    let placed = store
        .place(part, &ids, &context.syntax_uid)
        .map_err(|error| match error {
            PlaceError::Different | PlaceError::Unreadable(_) => (Status::Different, error.to_string()),
            PlaceError::Twice | PlaceError::NotAll { .. } | PlaceError::Io(_) => {
                (Status::OutOfResources, error.to_string())
            }
        });
    (Some((ids, was_hidden)), placed)
}
