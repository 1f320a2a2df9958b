//! The house: the laws of the architecture, measured on the source tree itself.
//!
//! Every crate below `services/` and `shared/` is parsed; nothing is compiled or run. A law is a
//! test with a sentence for a name, and when it is broken it lists the places and the cure. Each
//! checker is also seen turning red, on a small tree that breaks its law.
//!
//! ```sh
//! cargo test --release --test house
//! OBSID_HOUSE=another/tree cargo test --release --test house the_table_of_the_house -- --nocapture
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `tree`, `manifest`, `source`, `attributes`, `house` | files, manifests and syntax of a tree |
//! | `modules`, `resolve`, `references` | what a path in one file names in another |
//! | `circles` | files and crates that name each other |
//! | `sizes` | lines, functions, assertions |
//! | `constants` | names with two values |
//! | `one_of_each` | named methods that are written twice |
//! | `catalogue`, `matches_on_kinds` | knowledge of effects outside their catalogue |
//! | `partitions` | what a partition that flies links |
//! | `public_names` | documented and unused public items |
//! | `prose`, `wide_comments`, `wording`, `front_pages` | documentation as it is read |
//! | `findings`, `table` | everything measured once; the table |
#![forbid(unsafe_code)]

mod attributes;
mod catalogue;
mod circles;
mod constants;
mod findings;
mod front_pages;
mod house;
mod manifest;
mod matches_on_kinds;
mod modules;
mod one_of_each;
mod partitions;
mod prose;
mod public_names;
mod references;
mod resolve;
mod sizes;
mod source;
mod table;
mod tree;
mod wide_comments;
mod wording;

use findings::findings;
