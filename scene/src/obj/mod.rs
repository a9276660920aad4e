//! OBJ import.
