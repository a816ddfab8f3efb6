//! What is called on disk is there, whatever somebody removes.

use super::*;

/// A failure that the disk reports late once made what had been counted before it uncounted: 199 of 399 were told.
#[test]
fn a_late_word_of_the_disk_takes_back_no_count() {
    static FULL: AtomicU64 = AtomicU64::new(u64::MAX);
    let mut rig = Rig::new(&RecordingSpec::default(), |_| Ok(FULL.load(Ordering::Relaxed)));
    rig.record(2);
    FULL.store(0, Ordering::Relaxed);
    assert_eq!(rig.record(4).len(), 1);
    rig.fail_to_sync();
    assert!(rig.record(2).is_empty(), "that nothing is recorded is told once");
    assert!(rig.series.unrecorded() > 500);
    rig.assert_accounted();
}

/// `0 on disk, 51 synced` was in the status.
#[test]
fn what_was_synced_into_a_removed_file_is_not_called_synced() {
    let mut rig = Rig::new(&RecordingSpec::default(), plenty);
    rig.record(3);
    rig.series.syncer.settle();
    assert!(rig.series.durable() > 0);
    fs::remove_file(paths::recording(&rig.path("s.mcap"))).unwrap();
    rig.record(1);
    assert_eq!((rig.series.written(), rig.series.durable()), (0, 0));
}

/// 401 messages were called on disk in a folder that was not there.
#[test]
fn parts_that_were_removed_with_their_folder_are_not_called_on_disk() {
    let mut rig = Rig::new(&rotating(Duration::from_secs(2)), plenty);
    rig.record(5);
    // Else the folder goes away while a part is given its name, and recording stops for that instead.
    rig.series.syncer.settle();
    fs::remove_dir_all(rig.tmp.path()).unwrap();
    let said = rig.record(3);
    assert_eq!((rig.series.written(), rig.series.unrecorded()), (0, 800));
    assert!(said.iter().any(|words| words.contains("was removed")), "{said:?}");
    assert!(
        said.iter().any(|words| words.contains("401 messages were in them")),
        "{said:?}"
    );
}

/// The file was looked for once a second, and rotated between: 230 messages were called on disk.
#[test]
fn a_file_removed_just_before_it_is_rotated_is_not_called_on_disk() {
    let mut rig = Rig::new(&rotating(Duration::from_millis(2500)), plenty);
    rig.record_poses(230);
    fs::remove_file(paths::recording(&rig.path("s.mcap"))).unwrap();
    let said = rig.record_poses(25);
    assert!(said.len() == 2 && said[0].contains("was removed"), "{said:?}");
    assert!(rig.series.unrecorded() >= 230);
    rig.assert_accounted();
}

/// Whatever is removed, moved, full or not kept, in whatever order: what is called on disk is what can be read there.
#[test]
fn after_any_faults_what_is_called_on_disk_can_be_read_there() {
    static ROOM: AtomicU64 = AtomicU64::new(u64::MAX);
    for seed in 0..40_u64 {
        ROOM.store(u64::MAX, Ordering::Relaxed);
        let spec = RecordingSpec {
            rotate_after: (seed % 2 == 0).then(|| Duration::from_millis(2300)),
            ..RecordingSpec::default()
        };
        let mut rig = Rig::new(&spec, |_| Ok(ROOM.load(Ordering::Relaxed)));
        let mut state = seed * 2 + 1;
        for _ in 0..12 {
            // Knuth's MMIX generator.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            rig.record_poses((state >> 33) % 300);
            let growing = paths::recording(&rig.path("s.mcap"));
            match (state >> 50) % 7 {
                0 => ROOM.store(0, Ordering::Relaxed),
                1 => ROOM.store(u64::MAX, Ordering::Relaxed),
                2 => drop(fs::remove_file(growing)),
                3 => drop(fs::rename(growing, rig.path("elsewhere"))),
                4 => rig.fail_to_sync(),
                5 => drop(fs::remove_file(paths::part(&rig.path("s.mcap"), 1))),
                _ => {}
            }
            // It is looked for once a second.
            rig.record(2);
            rig.assert_accounted();
            // Completed files have their names once the disk has them.
            rig.series.syncer.settle();
            assert_eq!(rig.found(), rig.series.written(), "seed {seed}");
        }
    }
}
