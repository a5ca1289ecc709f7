/* Numbers of 113 bits: __float128 and libquadmath, or long double where it has them, as on arm64. */
#ifndef TOLIMAN_TESTS_QUAD_MATH_H
#define TOLIMAN_TESTS_QUAD_MATH_H

#if __LDBL_MANT_DIG__ == 113
#include <complex.h>
#include <math.h>

typedef long double quad;
typedef _Complex long double quad_complex;
#define QUAD(number) number##L
#define M_PIq 3.141592653589793238462643383279502884L
#define M_LN10q 2.302585092994045684017991454684364208L
#define atan2q atan2l
#define cexpiq(x) cexpl((x)*I)
#define cimagq cimagl
#define copysignq copysignl
#define cosq cosl
#define crealq creall
#define expq expl
#define fabsq fabsl
#define floorq floorl
#define hypotq hypotl
#define lgammaq lgammal
#define log10q log10l
#define log1pq log1pl
#define logq logl
#define powq powl
#define rintq rintl
#define sinq sinl
#define sqrtq sqrtl
#else
#include <quadmath.h>

typedef __float128 quad;
typedef __complex128 quad_complex;
#define QUAD(number) number##Q
#endif

#endif
