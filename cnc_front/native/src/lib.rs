//! The bridge to Python: columns and plain values across the border, the GIL released for all real work.
