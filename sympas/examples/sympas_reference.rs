//! Prints `docs/sympas.md`.

fn main() {
    print!("{}", sympas::reference::page());
}
