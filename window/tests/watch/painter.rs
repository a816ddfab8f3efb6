//! A small window that paints codes, and does wrong when it is told to.

use std::io::BufRead;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use bus::message::ProcessState;
use bus::process::{Membership, Process};
use window::code::{COLUMNS, Code, PROPERTY, Place, ROWS, Shown, key};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, ConnectionExt as _, CreateGCAux, CreateWindowAux, EventMask, ImageFormat, PropMode, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

use crate::stage::{CELL, RUN_DIR, SQUARE, WINDOW};

/// Between two pictures, as a window paints that has nothing new to show; faster than its limit of 100 ms.
const BETWEEN: Duration = Duration::from_millis(33);

fn orders() -> Receiver<String> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let _ = send.send(line);
        }
    });
    receive
}

/// Paints until it is told to end; every picture is green but for its cell.
pub(crate) fn paint() {
    let run_dir = PathBuf::from(std::env::var_os(RUN_DIR).unwrap());
    let mut process = Process::join("window", &Membership { run_dir, parent: None }).unwrap();
    let (x, screen) = RustConnection::connect(None).unwrap();
    let root = &x.setup().roots[screen];
    let (window, gc) = (x.generate_id().unwrap(), x.generate_id().unwrap());
    let (left, top, width, height) = WINDOW;
    let green = CreateWindowAux::new()
        .background_pixel(0x00_80_00)
        .event_mask(EventMask::NO_EVENT);
    let class = WindowClass::INPUT_OUTPUT;
    x.create_window(0, window, root.root, left, top, width, height, 0, class, 0, &green)
        .unwrap();
    x.create_gc(gc, window, &CreateGCAux::new()).unwrap();
    let own = key(process.run.epoch_ns);
    let place = Place {
        at: CELL,
        square: SQUARE,
        key: own,
        pid: std::process::id(),
    };
    let property = x.intern_atom(false, PROPERTY.as_bytes()).unwrap().reply().unwrap().atom;
    let cardinals = place.to_cardinals();
    x.change_property32(PropMode::REPLACE, window, property, AtomEnum::CARDINAL, &cardinals)
        .unwrap();
    x.map_window(window).unwrap();
    let orders = orders();
    let (mut order, mut seq, mut captured_ns) = ("paint".to_owned(), 0_u64, 0);
    loop {
        let old = order.clone();
        order = orders.try_iter().last().unwrap_or(order);
        if old != order {
            match order.as_str() {
                "hide" => drop(x.unmap_window(window).unwrap()),
                _ => drop(x.map_window(window).unwrap()),
            }
        }
        let now_ns = process.clock().now_ns();
        seq += u64::from(!matches!(order.as_str(), "freeze" | "alternate"));
        if order != "age" {
            captured_ns = now_ns;
        }
        let number = match order.as_str() {
            "alternate" => seq - now_ns as u64 / 40_000_000 % 2,
            _ => seq,
        };
        let code = Code::new(number, captured_ns, Shown::Live);
        if order != "freeze" {
            let grid = code.grid(if order == "foreign" { own + 1 } else { own });
            let pixels = grid.rgba(SQUARE);
            let [x0, y0] = CELL.map(|at| at as i16);
            let (w, h) = ((COLUMNS * SQUARE) as u16, (ROWS * SQUARE) as u16);
            x.put_image(
                ImageFormat::Z_PIXMAP,
                window,
                gc,
                w,
                h,
                x0,
                y0,
                0,
                root.root_depth,
                &pixels,
            )
            .unwrap();
        }
        x.flush().unwrap();
        let end = order == "end";
        process
            .beat(
                if end {
                    ProcessState::Stopping
                } else {
                    ProcessState::Ready
                },
                "",
            )
            .unwrap();
        if end {
            // The watcher hears of it before the window goes.
            std::thread::sleep(BETWEEN * 6);
            return;
        }
        std::thread::sleep(BETWEEN);
    }
}
