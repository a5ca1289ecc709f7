// Bytes of the smallest layout ever published for a struct, which the library goes on taking: today's, but for the
// structs that grew since, each with a line of this form. tools/check/abi reads and records them.
#pragma once
#include <cstddef>

#include <toliman/toliman.h>

namespace toliman::api {

template <class T> constexpr size_t kOldest = sizeof(T);

template <> inline constexpr size_t kOldest<toliman_sim_options> = offsetof(toliman_sim_options, engine);
template <> inline constexpr size_t kOldest<toliman_sim_plan_info> = offsetof(toliman_sim_plan_info, place_order);
template <> inline constexpr size_t kOldest<toliman_sim_info> = offsetof(toliman_sim_info, amplitude_uas);
template <> inline constexpr size_t kOldest<toliman_track_options> = offsetof(toliman_track_options, log);
template <> inline constexpr size_t kOldest<toliman_cae_train_options> = offsetof(toliman_cae_train_options, losses);
template <> inline constexpr size_t kOldest<toliman_period_model> = offsetof(toliman_period_model, flags);

} // namespace toliman::api
