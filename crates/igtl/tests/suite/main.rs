//! The codec and the sessions of OpenIGTLink, from outside.

mod crc;
mod damage;
mod golden;
mod support;
