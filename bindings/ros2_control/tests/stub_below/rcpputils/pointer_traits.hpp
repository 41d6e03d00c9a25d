// Stub for tests alone: see README.md of this folder.
#pragma once
#include <type_traits>

namespace rcpputils {
template <class T>
struct is_pointer : std::is_pointer<T> {};
}  // namespace rcpputils
