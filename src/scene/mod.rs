//! What a run is asked to do: scenes and site files.
