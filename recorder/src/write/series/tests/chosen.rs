//! What a person chose holds in every file of a session.

use bus::message::Guide;

use super::*;
use crate::read::scan::Item;
use crate::read::seek::Session;
use crate::wire::schema::WORKFLOW;

fn guide(t_ns: i64, plan_id: u64) -> proto::Guide {
    proto::Guide::from(&Guide {
        t_ns,
        plan_id,
        ..Guide::default()
    })
}

fn plans(path: &Path) -> Vec<(i64, u64)> {
    let found = Session::open(path).unwrap().guides().unwrap();
    assert!(found.unread.is_empty(), "{:?}", found.unread);
    found.messages.iter().map(|guide| (guide.t_ns, guide.plan_id)).collect()
}

#[test]
fn every_file_begins_with_what_was_chosen_last() {
    let spec = rotating(Duration::from_secs(2));
    let mut rig = Rig::new(&spec, plenty);
    rig.series.guide(0, &guide(0, 1));
    rig.record(3);
    rig.series.guide(rig.now_ns, &guide(rig.now_ns, 2));
    rig.record(3);
    assert_eq!(rig.series.parts(), 2);
    let (now_ns, chosen_ns) = (rig.now_ns, 3 * SECOND);
    let series = std::mem::replace(&mut rig.series, Rig::new(&spec, plenty).series);
    series.finish(now_ns, &no_facts()).unwrap();
    assert_eq!(plans(&rig.path("s.1.mcap")), [(0, 1)]);
    assert_eq!(plans(&rig.path("s.2.mcap")), [(0, 1), (chosen_ns, 2)]);
    assert_eq!(plans(&rig.path("s.mcap")), [(chosen_ns, 2)]);
    // A file is not as long as the session because of it.
    let span = Session::open(&rig.path("s.mcap")).unwrap().span_ns().unwrap();
    assert!(span.0 >= 4 * SECOND.unsigned_abs(), "{span:?}");
}

/// When and with which flags the workflow was written down.
fn flags(path: &Path) -> Vec<(u64, u32)> {
    let each = crate::read::scan::open(path)
        .unwrap()
        .filter_map(|item| match item.unwrap() {
            Item::Message(message) if message.channel.topic == WORKFLOW => {
                let workflow = <proto::Workflow as prost::Message>::decode(&*message.data).unwrap();
                Some((message.log_time, workflow.flags))
            }
            _ => None,
        });
    each.collect()
}

/// Of a session in parts only the first said that it had navigated unchecked.
#[test]
fn every_file_begins_with_how_far_the_run_had_come() {
    let spec = rotating(Duration::from_secs(2));
    let mut rig = Rig::new(&spec, plenty);
    let workflow = |t_ns: i64, flags: u32| proto::Workflow {
        t_ns,
        flags,
        ..proto::Workflow::default()
    };
    rig.series.workflow(0, &workflow(0, 1));
    rig.record(3);
    rig.series.workflow(rig.now_ns, &workflow(rig.now_ns, 2));
    rig.record(3);
    let now_ns = rig.now_ns;
    let series = std::mem::replace(&mut rig.series, Rig::new(&spec, plenty).series);
    series.finish(now_ns, &no_facts()).unwrap();
    assert_eq!(flags(&rig.path("s.1.mcap")), [(0, 1)]);
    let second = flags(&rig.path("s.2.mcap"));
    assert_eq!(second.iter().map(|one| one.1).collect::<Vec<_>>(), [1, 2]);
    // Said again when the file begins, and no earlier: its report would count the time before.
    assert!(
        second[0].0 >= 2 * SECOND.unsigned_abs() && second[1].0 == 3 * SECOND.unsigned_abs(),
        "{second:?}"
    );
    let third = flags(&rig.path("s.mcap"));
    assert!(
        third.len() == 1 && third[0].1 == 2 && third[0].0 >= 4 * SECOND.unsigned_abs(),
        "{third:?}"
    );
}

#[test]
fn what_is_chosen_while_nothing_can_be_written_stands_in_the_next_file() {
    let mut rig = Rig::new(&RecordingSpec::default(), plenty);
    rig.series.guide(0, &guide(0, 1));
    rig.record(1);
    rig.fail_to_sync();
    rig.record(2);
    assert!(rig.series.stopped().is_some());
    rig.series.guide(rig.now_ns, &guide(5, 2));
    rig.record(10);
    assert!(rig.series.stopped().is_none());
    let now_ns = rig.now_ns;
    let series = std::mem::replace(&mut rig.series, Rig::new(&RecordingSpec::default(), plenty).series);
    series.finish(now_ns, &no_facts()).unwrap();
    assert_eq!(plans(&rig.path("s.mcap")), [(5, 2)]);
}

#[test]
fn every_file_begins_with_the_organs_that_its_states_are_of() {
    let spec = rotating(Duration::from_secs(2));
    let mut rig = Rig::new(&spec, plenty);
    rig.record(3);
    let mesh = proto::MeshFrame {
        header: bus::message::TissueMeshHeader {
            mesh_id: [5; 32],
            q: [1.0, 0.0, 0.0, 0.0],
            ..Default::default()
        },
        bytes: vec![1, 2, 3],
    };
    rig.series.mesh(rig.now_ns, proto::TissueMesh::of(rig.now_ns, &mesh));
    rig.record(3);
    let now_ns = rig.now_ns;
    let series = std::mem::replace(&mut rig.series, Rig::new(&spec, plenty).series);
    series.finish(now_ns, &no_facts()).unwrap();
    let meshes = |name: &str| {
        let found = Session::open(&rig.path(name)).unwrap().meshes().unwrap();
        assert!(found.unread.is_empty(), "{:?}", found.unread);
        found.messages
    };
    assert_eq!(meshes("s.1.mcap"), []);
    assert_eq!((meshes("s.2.mcap"), meshes("s.mcap")), (vec![mesh.clone()], vec![mesh]));
}
