//! The program `ltbw`.

fn main() {}
