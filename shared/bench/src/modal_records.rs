//! Records as they are: structures drawn at random, recorded with every defect that real records
//! have, and read as a user's file is.

pub mod generator;
pub mod known_input;
