//! The `chebloyd` program.

fn main() {}
