//! Sample replies cut at every byte, and with every byte changed: no panic, and no tool of a reply with a wrong CRC.

use ndi::{
    Bx2, Frame, ReplyOption, binary_reply, bx_body, bx2_body, parse_bx, parse_bx2, parse_tx, text_reply, tx_text,
};

use crate::polled::full;
use crate::support::{Owned, frame, stream, tool};

const OPTIONS: ReplyOption = ReplyOption(0x1807);

fn samples() -> Vec<Vec<u8>> {
    let bx2 = Bx2 {
        frames: vec![frame(7, vec![tool(1, 0), tool(2, 0x10D), tool(3, 9)])],
        ..Bx2::default()
    };
    vec![
        text_reply("OKAY"),
        text_reply(&tx_text(&full(), OPTIONS)),
        binary_reply(&bx_body(&full(), OPTIONS)),
        binary_reply(&bx2_body(&bx2)),
    ]
}

/// All that can be made of a reply.
fn read(reply: &Owned) -> Vec<Frame> {
    match reply {
        Owned::Text(text) => {
            parse_tx(text, OPTIONS).map_or_else(|_| Vec::new(), |polled| Frame::of_polled(&polled, 1e-3))
        }
        Owned::Binary(body) => {
            let bx = parse_bx(body, OPTIONS).map_or_else(|_| Vec::new(), |polled| Frame::of_polled(&polled, 1e-3));
            let bx2 = parse_bx2(body).map_or_else(|_| Vec::new(), |reply| Frame::of_bx2(&reply, 1e-3));
            [bx, bx2].concat()
        }
    }
}

#[test]
fn cut_at_every_byte_it_is_cut() {
    for sample in samples() {
        for end in 1..sample.len() {
            let said = stream(&sample[..end], 7);
            assert!(matches!(&said[..], [Err(_)]), "{end}: {said:?}");
        }
    }
}

#[test]
fn no_changed_byte_makes_a_tool_of_a_reply_with_a_wrong_crc() {
    for sample in samples() {
        let good = stream(&sample, 64);
        for at in 0..sample.len() {
            for change in [1, 2, 4, 8, 16, 32, 64, 128, 255] {
                let mut bytes = sample.clone();
                bytes[at] ^= change;
                for said in stream(&bytes, 64).into_iter().flatten() {
                    // A digit of a CRC in lower case is the same CRC.
                    assert!(good.contains(&Ok(said.clone())), "{at} {change}");
                    drop(read(&said));
                }
            }
        }
    }
}

#[test]
fn bodies_that_were_changed_and_given_a_right_crc_never_panic() {
    for sample in samples() {
        let good = stream(&sample, 64)[0].clone().unwrap();
        let Owned::Binary(body) = good else { continue };
        for at in 0..body.len() {
            for change in [1, 0x40, 0x80, 0xFF] {
                let mut body = body.clone();
                body[at] ^= change;
                for frame in read(&Owned::Binary(body)) {
                    drop(frame.fields().json());
                }
            }
            drop(read(&Owned::Binary(body[..at].to_vec())));
        }
    }
}
