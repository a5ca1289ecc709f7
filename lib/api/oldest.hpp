// Size of the first published layout of each struct, which the library still accepts. It is the current size, except
// for structs that have grown since; each of these has a line of the form
//   template <> inline constexpr size_t kOldest<toliman_x> = offsetof(toliman_x, first_new_member);
// tools/check/abi reads and records them.
#pragma once
#include <cstddef>

#include <toliman/toliman.h>

namespace toliman::api {

template <class T> constexpr size_t kOldest = sizeof(T);
template <> inline constexpr size_t kOldest<toliman_sim_options> = offsetof(toliman_sim_options, bad_pixels);
template <> inline constexpr size_t kOldest<toliman_sim_info> = offsetof(toliman_sim_info, exposure_s);
template <> inline constexpr size_t kOldest<toliman_sim_plan_info> = offsetof(toliman_sim_plan_info, bad_pixels);
template <> inline constexpr size_t kOldest<toliman_sim_bounds> = offsetof(toliman_sim_bounds, peak_to_mean);
template <> inline constexpr size_t kOldest<toliman_mask_info> = offsetof(toliman_mask_info, gradient_energy_before);
template <> inline constexpr size_t kOldest<toliman_cae_options> = offsetof(toliman_cae_options, log);
template <> inline constexpr size_t kOldest<toliman_cae_info> = offsetof(toliman_cae_info, centre);
template <> inline constexpr size_t kOldest<toliman_cae_train_options> = offsetof(toliman_cae_train_options, epoch);
template <> inline constexpr size_t kOldest<toliman_components_options> = offsetof(toliman_components_options, log);
template <> inline constexpr size_t kOldest<toliman_linear_options> = offsetof(toliman_linear_options, log);
template <> inline constexpr size_t kOldest<toliman_track_options> = offsetof(toliman_track_options, stamp);
template <> inline constexpr size_t kOldest<toliman_track_info> = offsetof(toliman_track_info, unreduced);
template <> inline constexpr size_t kOldest<toliman_sky_info> = offsetof(toliman_sky_info, parallax_arcsec);
template <> inline constexpr size_t kOldest<toliman_period_options> = offsetof(toliman_period_options, trend);
template <> inline constexpr size_t kOldest<toliman_period_info> = offsetof(toliman_period_info, trend);
template <>
inline constexpr size_t kOldest<toliman_period_bootstrap_options> = offsetof(toliman_period_bootstrap_options, rows);
template <>
inline constexpr size_t kOldest<toliman_period_batch_options> = offsetof(toliman_period_batch_options, trend);

} // namespace toliman::api
