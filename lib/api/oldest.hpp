// Bytes of the smallest layout ever published for a struct, which the library goes on taking: today's, but for the
// structs that grew since, each with a line of the form
//   template <> inline constexpr size_t kOldest<toliman_x> = offsetof(toliman_x, first_new_member);
// tools/check/abi reads and records them.
#pragma once
#include <cstddef>

#include <toliman/toliman.h>

namespace toliman::api {

template <class T> constexpr size_t kOldest = sizeof(T);

} // namespace toliman::api
