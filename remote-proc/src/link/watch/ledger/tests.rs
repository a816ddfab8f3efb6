use super::*;

const SECOND: i64 = 1_000_000_000;

fn peer(last: u8, port: u16) -> SocketAddr {
    ([10, 0, 0, last], port).into()
}

/// Looks at `one` ten times a second for `seconds`, while it says and takes so much a second; whether it was cut off.
fn is_cut(ledger: &mut Ledger, one: SocketAddr, seconds: u64, a_second: (u64, u64)) -> bool {
    (0..=10 * seconds).any(|tenth| {
        let looked = Looked {
            peer: one,
            said: a_second.0 * tenth / 10,
            taken: a_second.1 * tenth / 10,
        };
        !ledger.look(tenth as i64 * SECOND / 10, &[looked], 0).is_empty()
    })
}

#[test]
fn a_receiver_that_looks_on_and_one_that_pulls_pieces_are_let_be() {
    let day = 86_400;
    assert!(!is_cut(&mut Ledger::default(), peer(1, 1), day, (1000, 40_000)));
    // 1600 pieces a second, as fast as the loopback gives them.
    assert!(!is_cut(
        &mut Ledger::default(),
        peer(1, 1),
        60,
        (1600 * 180, 1600 << 17)
    ));
    let mut ledger = Ledger::default();
    let all_at_once = Looked {
        peer: peer(1, 1),
        said: 10_000,
        taken: 0,
    };
    assert_eq!(ledger.look(0, &[all_at_once], 0), []);
}

#[test]
fn who_says_more_is_cut_off_and_kept_out_by_address_for_a_while() {
    let mut ledger = Ledger::default();
    assert!(is_cut(&mut ledger, peer(1, 1), 60, (8000, 40_000)));
    assert!(is_cut(&mut Ledger::default(), peer(1, 1), 1, (1 << 20, 1 << 20)));
    let mut ledger = Ledger::default();
    let looked = |last, port, said| Looked {
        peer: peer(last, port),
        said,
        taken: 0,
    };
    // Of two from one address and one from another, one says too much.
    let loud = [looked(1, 1, 70_000), looked(1, 2, 100), looked(2, 1, 100)];
    assert_eq!(ledger.look(0, &loud, 0), [(peer(1, 1), Why::Says)]);
    assert!(ledger.is_guarding());
    // Those that stand stay; whoever comes from there is turned away.
    let later = [looked(1, 2, 200), looked(2, 1, 200), looked(1, 3, 0), looked(2, 3, 0)];
    assert_eq!(ledger.look(SECOND, &later, 0), [(peer(1, 3), Why::ShutOut)]);
    assert_eq!(ledger.look(61 * SECOND, &later, 0), []);
    assert!(!ledger.is_guarding());
}

#[test]
fn where_memory_grows_the_one_that_says_most_goes_and_good_ones_stay() {
    let mut ledger = Ledger::default();
    let (hour, second) = (3600, SECOND);
    // One that looked on for an hour said more bytes than one that declares slowly for a minute.
    let good = |seconds: u64| Looked {
        peer: peer(1, 1),
        said: 4000 + 800 * seconds,
        taken: 40_000 * seconds,
    };
    for seconds in 0..hour {
        assert_eq!(ledger.look(seconds as i64 * second, &[good(seconds)], MEMORY), []);
    }
    for since in 0..60 {
        let bad = Looked {
            peer: peer(2, 1),
            said: 4000 + 2000 * since,
            taken: 0,
        };
        let (at, both) = ((hour + since) as i64 * second, [good(hour + since), bad]);
        let memory = if since < 59 { MEMORY } else { MEMORY + 1 };
        let cut = ledger.look(at, &both, memory);
        assert_eq!(
            cut,
            if since < 59 {
                vec![]
            } else {
                vec![(peer(2, 1), Why::Memory)]
            }
        );
    }
}

/// Somebody who declares as slowly as a good receiver asks: all begin anew, and what was declared is gone.
#[test]
fn where_nobody_says_more_than_the_others_all_are_cut_off_and_come_again_at_once() {
    let mut ledger = Ledger::default();
    let looked = |port, said| Looked {
        peer: peer(1, port),
        said,
        taken: 0,
    };
    let both = [looked(1, 3000), looked(2, 3000)];
    let mut cut = ledger.look(0, &both, MEMORY + 1);
    cut.sort_by_key(|(peer, _)| peer.port());
    assert_eq!(cut, [(peer(1, 1), Why::Anew), (peer(1, 2), Why::Anew)]);
    // They are let in, and not cut off again and again where it did not help.
    let back = [looked(3, 3000), looked(4, 3000)];
    assert_eq!(ledger.look(SECOND, &back, MEMORY + 1), []);
    assert!(!ledger.is_guarding());
    assert_eq!(ledger.look(61 * SECOND, &back, MEMORY + 1).len(), 2);
}
