//! A stream in pieces says what it says in one.

use igtl::{Decoder, Fault, HEADER_BYTES, Limits, Recovery, decode};
use proptest::prelude::*;

use crate::support::{framed, golden, raw, stream, transform};

/// Good messages, refused ones among them, and one that is cut.
fn mixed() -> Vec<u8> {
    let mut bad = raw("STRING", &[0, 3, 0, 1, b'a']);
    bad[50] ^= 1;
    let good = transform().to_vec().unwrap();
    let log = framed(1, b"TRANSFORM", b"a\nb", &[0; 300]);
    let empty = framed(1, b"GET_STATUS", b"a\nb", &[]);
    [
        &good[..],
        &bad,
        &log,
        &good,
        &empty,
        &raw("TDATA", &[0; 69]),
        &good,
        &good[..90],
    ]
    .concat()
}

#[test]
fn one_byte_at_a_time_is_all_at_once() {
    let (bytes, limits) = (mixed(), Limits::POSES);
    let whole = stream(&bytes, &[bytes.len()], limits);
    assert_eq!(whole.len(), 8);
    assert_eq!(whole.iter().filter(|one| one.is_ok()).count(), 3);
    assert_eq!(stream(&bytes, &[1], limits), whole);
    let all: Vec<u8> = golden().into_iter().flat_map(|(_, bytes)| bytes).collect();
    let whole = stream(&all, &[all.len().max(1)], limits);
    assert!(whole.iter().all(Result::is_ok) && (all.is_empty() || whole.len() == 24));
    assert_eq!(stream(&all, &[1], limits), whole);
}

proptest! {
    #[test]
    fn pieces_of_any_lengths_say_the_same(pieces in prop::collection::vec(1_usize..400, 1..9)) {
        let bytes = mixed();
        prop_assert_eq!(stream(&bytes, &pieces, Limits::POSES), stream(&bytes, &[bytes.len()], Limits::POSES));
    }

    #[test]
    fn any_bytes_are_taken_without_a_panic_and_alike(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        pieces in prop::collection::vec(1_usize..90, 1..5),
    ) {
        let whole = stream(&bytes, &[300], Limits::POSES);
        prop_assert_eq!(stream(&bytes, &pieces, Limits::POSES), whole);
        let _ = decode(&bytes, &Limits::POSES);
    }
}

#[test]
fn it_says_how_many_bytes_it_wants_and_how_many_of_a_message_have_come() {
    let bytes = transform().to_vec().unwrap();
    let mut decoder = Decoder::new(Limits::POSES);
    assert_eq!((decoder.wants(), decoder.come()), (58, 0));
    assert!(decoder.feed(&mut &bytes[..50]).is_none());
    assert_eq!((decoder.wants(), decoder.come()), (8, 50));
    assert!(decoder.feed(&mut &bytes[50..58]).is_none());
    assert_eq!(decoder.wants(), (bytes.len() - HEADER_BYTES) as u64);
    assert!(decoder.feed(&mut &bytes[58..60]).is_none());
    assert_eq!(decoder.come(), 60);
    assert!(decoder.feed(&mut &bytes[60..]).unwrap().is_ok());
    assert_eq!((decoder.wants(), decoder.come()), (58, 0));
}

#[test]
fn what_is_thrown_away_is_counted_too() {
    let bytes = framed(1, b"TRANSFORM", b"a\nb", &[0; 300]);
    let mut decoder = Decoder::new(Limits::POSES);
    let mut rest = &bytes[..100];
    assert!(decoder.feed(&mut rest).unwrap().is_err());
    assert_eq!((decoder.come(), decoder.wants(), rest.len()), (58, 300, 42));
    assert!(decoder.feed(&mut rest).is_none());
    assert_eq!((decoder.come(), decoder.wants()), (100, 258));
    assert!(decoder.feed(&mut &bytes[100..]).is_none());
    assert_eq!((decoder.come(), decoder.wants()), (0, 58));
}

#[test]
fn it_says_where_in_the_stream_a_message_began() {
    let (bytes, one) = (mixed(), transform().to_vec().unwrap().len() as u64);
    let (mut decoder, mut rest, mut began) = (Decoder::new(Limits::POSES), &bytes[..], Vec::new());
    while decoder.feed(&mut rest).is_some() {
        began.push(decoder.began());
    }
    let lengths = [0, one, 58 + 5, 58 + 300, one, 58, 58 + 69];
    let mut at = 0;
    let starts = lengths.map(|length| {
        at += length;
        at
    });
    assert_eq!(began, starts);
}

#[test]
fn bytes_can_be_read_to_where_they_are_needed() {
    let bytes = mixed();
    let whole = stream(&bytes, &[bytes.len()], Limits::POSES);
    let mut decoder = Decoder::new(Limits::POSES);
    let (mut rest, mut said) = (&bytes[..], Vec::new());
    loop {
        while let Some(one) = decoder.take() {
            said.push(one.map(igtl::Message::into_owned));
        }
        let room = decoder.space();
        let count = room.len().min(rest.len());
        if count == 0 {
            break;
        }
        room[..count].copy_from_slice(&rest[..count]);
        rest = &rest[count..];
        decoder.filled(count);
    }
    said.extend(decoder.end().map(Err));
    assert_eq!(said, whole);
}

#[test]
fn a_body_that_is_announced_gets_room_as_it_comes() {
    let mut head = raw("IMAGE", &[]);
    head[42..50].copy_from_slice(&(500_u64 << 20).to_be_bytes());
    let mut decoder = Decoder::new(Limits::VOLUMES);
    assert!(decoder.feed(&mut &head[..]).is_none());
    let mut came = 0;
    while came < 1 << 20 {
        let room = decoder.space().len();
        assert!(room <= came.max(64 << 10), "{room} after {came}");
        decoder.filled(room);
        came += room;
        assert!(decoder.take().is_none());
    }
    assert_eq!(decoder.wants(), (500 << 20) - came as u64);
}

#[test]
fn a_closed_stream_takes_nothing_and_says_why_again() {
    let mut decoder = Decoder::new(Limits::POSES);
    let mut bytes = &b"GET / HTTP/1.1\r\nHost: x\r\n"[..];
    let error = decoder.feed(&mut bytes).unwrap().unwrap_err();
    assert_eq!(
        (&error.fault, error.recovery),
        (&Fault::Protocol("HTTP"), Recovery::Close)
    );
    assert_eq!((decoder.wants(), decoder.space().len()), (0, 0));
    let mut more = &transform().to_vec().unwrap()[..];
    assert_eq!(decoder.feed(&mut more), Some(Err(error.clone())));
    assert_eq!(decoder.end(), Some(error));
}

#[test]
fn voxels_are_borrowed_from_where_they_lie() {
    for (_, bytes) in golden().into_iter().filter(|(name, _)| name == "image") {
        let (message, _) = decode(&bytes, &Limits::default()).unwrap();
        let encoded = message.encode().unwrap();
        let [head, voxels, tail] = encoded.pieces();
        assert_eq!((head.len(), voxels.len(), tail.len()), (58 + 72, 2500, 0));
        assert!(bytes.as_ptr_range().contains(&voxels.as_ptr()));
    }
}
