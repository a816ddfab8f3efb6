//! The painter that needs no card, from outside.

mod damage;
mod forms;
mod hostile;
mod made;
mod reference;
mod screen;
mod screens;
