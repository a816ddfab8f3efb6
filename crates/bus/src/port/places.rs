//! Who holds the places of a service: a topic has so many readers at most, and other programs of the same user may take them all.

use std::collections::BTreeMap;
use std::fmt::{self, Debug, Display};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::NodeView;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::event::PortFactory as EventFactory;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as StreamFactory;
use iceoryx2::service::port_factory::request_response::PortFactory as RequestFactory;

use crate::message::{Command, ReplyHeader};
use crate::node::Ipc;
use crate::{Bus, BusError};

/// A service is crowded where one place in so many is left, or fewer.
const FREE_OF: usize = 12;

/// A service whose readers' places are all taken, or nearly so.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Crowded {
    /// The service.
    pub service: String,
    /// How many places are taken.
    pub taken: usize,
    /// How many there are.
    pub places: usize,
    /// Process, its program where it is known, and how many places it holds; most first.
    pub holders: Vec<(u32, String, usize)>,
}

impl Display for Crowded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let holders = self.holders.iter().take(4);
        let holders: Vec<String> = holders
            .map(|(pid, program, count)| format!("{count} by process {pid} ({program})"))
            .collect();
        write!(
            f,
            "{} of {} places of {:?} are taken, {}",
            self.taken,
            self.places,
            self.service,
            holders.join(", ")
        )
    }
}

/// A service whose readers can be counted.
pub(super) trait Places: Debug {
    /// How many places are taken, and how many there are.
    fn count(&self) -> (usize, usize);
    /// The node of each taken place.
    fn readers(&self) -> Vec<UniqueNodeId>;
    /// Every node of the service, with its process and program.
    fn programs(&self) -> BTreeMap<UniqueNodeId, (u32, String)>;
    fn service(&self) -> String;

    /// Who holds the places, most first.
    fn held(&self) -> Crowded {
        let ((taken, places), programs) = (self.count(), self.programs());
        let mut counts: BTreeMap<(u32, String), usize> = BTreeMap::new();
        for node in self.readers() {
            let program = programs.get(&node).cloned();
            *counts.entry(program.unwrap_or((0, "unknown".to_owned()))).or_default() += 1;
        }
        let mut holders: Vec<_> = counts
            .into_iter()
            .map(|((pid, name), count)| (pid, name, count))
            .collect();
        holders.sort_by_key(|holder| std::cmp::Reverse(holder.2));
        Crowded {
            service: self.service(),
            taken,
            places,
            holders,
        }
    }

    /// Who crowds the service; `None` while it has room. The way without a crowd reads two numbers.
    fn crowded(&self) -> Option<Crowded> {
        let (taken, places) = self.count();
        let is_crowded = places.saturating_sub(taken) * FREE_OF <= places;
        is_crowded.then(|| self.held())
    }
}

/// How many of a service's places guests leave free: enough for every process of a usual scene to be started again at once
/// while its dead predecessor still holds a place, and never more than a third.
fn kept_free(places: usize) -> usize {
    const PROCESSES: usize = 8;
    PROCESSES.min(places / 3)
}

/// Makes a port that takes one of a service's places. Says who holds them where there is none for this process.
pub(super) fn take_place<S: Places, P, E: Debug>(
    (bus, service): (&Bus, &S),
    (topic, what): (&str, &'static str),
    create: impl FnOnce(&S) -> Result<P, E>,
) -> Result<P, BusError> {
    let refused = |why: String| BusError::Open {
        topic: topic.to_owned(),
        what,
        why,
    };
    let (taken, places) = service.count();
    let kept = kept_free(places);
    if bus.is_guest() && taken + kept >= places {
        let held = service.held();
        return Err(refused(format!(
            "{held}, and the last {kept} are kept for the run's own processes"
        )));
    }
    create(service).map_err(|e| {
        refused(
            service
                .crowded()
                .map_or_else(|| format!("{e:?}"), |crowded| crowded.to_string()),
        )
    })
}

fn programs(factory: &impl PortFactory<Service = Ipc>) -> BTreeMap<UniqueNodeId, (u32, String)> {
    let mut found = BTreeMap::new();
    let _ = factory.nodes(|state| {
        if let NodeState::Alive(node) = state
            && let Some(details) = node.details()
        {
            let pid = u32::try_from(details.process_id().value()).unwrap_or(0);
            found.insert(*node.id(), (pid, details.executable().to_string()));
        }
        CallbackProgression::Continue
    });
    found
}

/// The nodes that `list` names, each as often as it does.
fn listed(list: impl FnOnce(&mut dyn FnMut(UniqueNodeId))) -> Vec<UniqueNodeId> {
    let mut nodes = Vec::new();
    list(&mut |node| nodes.push(node));
    nodes
}

macro_rules! places {
    ([$($generics:tt)*] $factory:ty, $count:ident, $most:ident, $list:ident) => {
        impl<$($generics)*> Places for $factory {
            fn count(&self) -> (usize, usize) {
                (self.dynamic_config().$count(), self.static_config().$most())
            }

            fn readers(&self) -> Vec<UniqueNodeId> {
                listed(|add| {
                    self.dynamic_config().$list(|details| {
                        add(details.node_id);
                        CallbackProgression::Continue
                    });
                })
            }

            fn programs(&self) -> BTreeMap<UniqueNodeId, (u32, String)> {
                programs(self)
            }

            fn service(&self) -> String {
                self.name().to_string()
            }
        }
    };
}

places!([P: Debug + IceoryxSend + ?Sized, H: Debug + ZeroCopySend] StreamFactory<Ipc, P, H>, number_of_subscribers, max_subscribers, list_subscribers);
places!([] RequestFactory<Ipc, Command, (), [u8], ReplyHeader>, number_of_clients, max_clients, list_clients);
places!([] EventFactory<Ipc>, number_of_listeners, max_listeners, list_listeners);
