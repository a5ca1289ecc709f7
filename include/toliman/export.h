/* Symbol visibility and compiler attributes. Included by every public header; nothing here is for callers. */
#ifndef TOLIMAN_EXPORT_H
#define TOLIMAN_EXPORT_H

#include <stddef.h> /* C99 forbids an empty translation unit */

#if defined(__GNUC__)
#define TOLIMAN_API __attribute__((visibility("default")))
#define TOLIMAN_MUST_CHECK __attribute__((warn_unused_result))
#else
#define TOLIMAN_API
#define TOLIMAN_MUST_CHECK
#endif

#ifdef __cplusplus
#define TOLIMAN_BEGIN_DECLS extern "C" {
#define TOLIMAN_END_DECLS }
#define TOLIMAN_NOEXCEPT noexcept
#else
#define TOLIMAN_BEGIN_DECLS
#define TOLIMAN_END_DECLS
#define TOLIMAN_NOEXCEPT
#endif

#endif
