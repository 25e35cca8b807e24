//! G-code files read as a printer reads them: the plastic they deposit, bead by bead.
//!
//! ```text
//! lines      bytes → lines with their numbers and ends
//! words      a line → its command and words, each with its place in the line
//! comments   a comment → the slicer's mark: feature type, layer, object, …
//! settings   comments → diameter and density of each tool's filament
//! survey     the whole file once, for what stands at its end or decides how the rest is read
//! machine    commands → motion and plastic pushed: modes, units, registers, retraction
//! arc, bead  a motion that deposits → its ten moments, in closed form
//! layers     heights of beads, from marks or from differences of z
//! reader     the whole file once more: beads with their heights, types, tools and objects
//! weigh      their moments, summed
//! part       the part on the bed: its box, its first layer, its infill; filling: how full that is
//! flow       what multiplies the flow of pieces of infill: a field, or numbers found for them
//! modulate   the file written anew, line by line, with that flow
//!   move_text, rewrite, pace    lines in pieces; words and checksums; F
//!   stale                       what comments say about the whole print
//! ```
//!
//! Memory does not grow with the file: one line, and one sum for each combination of type, tool and
//! object, are held.

pub(crate) mod arc;
pub(crate) mod bead;
pub(crate) mod comments;
pub(crate) mod error;
pub(crate) mod filling;
pub(crate) mod flow;
pub(crate) mod infill;
pub(crate) mod labels;
pub(crate) mod layers;
pub(crate) mod lines;
pub(crate) mod machine;
pub(crate) mod modulate;
pub(crate) mod move_text;
pub(crate) mod pace;
pub(crate) mod part;
pub(crate) mod reader;
pub(crate) mod rewrite;
pub(crate) mod settings;
pub(crate) mod stale;
pub(crate) mod survey;
pub(crate) mod weigh;
pub(crate) mod words;
