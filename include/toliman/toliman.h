/* Includes every header of libtoliman. Data flow: scene -> frames -> latent -> period. */
#ifndef TOLIMAN_TOLIMAN_H
#define TOLIMAN_TOLIMAN_H

#include <toliman/bank.h>
#include <toliman/base.h>
#include <toliman/budget.h>
#include <toliman/cae.h>
#include <toliman/calibrate.h>
#include <toliman/coadd.h>
#include <toliman/components.h>
#include <toliman/core.h>
#include <toliman/fit.h>
#include <toliman/frame.h>
#include <toliman/goodness.h>
#include <toliman/image.h>
#include <toliman/ingest.h>
#include <toliman/linear.h>
#include <toliman/mask.h>
#include <toliman/measure.h>
#include <toliman/period.h>
#include <toliman/period_batch.h>
#include <toliman/period_fap.h>
#include <toliman/period_noise.h>
#include <toliman/period_nuisance.h>
#include <toliman/period_sampling.h>
#include <toliman/planet.h>
#include <toliman/series.h>
#include <toliman/sim.h>
#include <toliman/sim_derivative.h>
#include <toliman/sky.h>
#include <toliman/sky_diagnosis.h>
#include <toliman/spread.h>
#include <toliman/track.h>
#include <toliman/track_goodness.h>
#include <toliman/track_options.h>
#include <toliman/track_outcome.h>
#include <toliman/track_records.h>

#endif
