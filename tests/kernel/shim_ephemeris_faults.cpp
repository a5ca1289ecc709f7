// The same functions as for test_ephemeris.
#include "shim_ephemeris.cpp"
