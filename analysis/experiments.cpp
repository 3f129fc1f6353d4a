#include "analysis/experiments.h"
