//! One page with the curves, cells and figures of runs, as a file that a browser opens without a network.
//!
//! [`run`] gathers what the page shows of a run, [`cells`] its cells, [`packing`] makes bytes of them,
//! [`html`] puts everything into one text. The page's own parts, a style and a program without
//! dependencies, stand in `page/`. Nothing here touches a file system.

pub(crate) mod cells;
pub(crate) mod html;
pub(crate) mod packing;
pub(crate) mod run;
