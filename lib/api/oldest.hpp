// Size of the first published layout of each struct, which the library still accepts. It is the current size, except
// for structs that have grown since a release; each of these has a line of the form
//   template <> inline constexpr size_t kOldest<toliman_x> = offsetof(toliman_x, first_new_member);
// tools/check/abi reads and records them.
#pragma once
#include <cstddef>

#include <toliman/toliman.h>

namespace toliman::api {

template <class T> constexpr size_t kOldest = sizeof(T);

} // namespace toliman::api
