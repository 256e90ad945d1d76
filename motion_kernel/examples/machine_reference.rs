//! Writes `docs/machine-file.md`.

fn main() {
    print!("{}", motion_kernel::machine::machine_reference());
}
