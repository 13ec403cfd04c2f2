/* The words of CUDA that generated code uses, for a C++ compiler: kernels run one thread after another.
 *
 * The threads of a block that come later read from its shared memory what the first has written there.
 */
#ifndef CUDA_ON_HOST
#define CUDA_ON_HOST

#include <math.h>
#include <stddef.h>
#include <utility>

#define __CUDACC__
#define __global__
#define __device__
#define __shared__ static
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(...)

struct dim3 {
    unsigned int x, y, z;
    explicit dim3(unsigned int x = 1) : x(x), y(1), z(1) {}
};

typedef int cudaError_t;
typedef struct Stream *cudaStream_t;
const cudaError_t cudaSuccess = 0;

static dim3 threadIdx, blockIdx, blockDim, gridDim;

static inline void __syncthreads() {}

template <class... Types, size_t... k>
static void run(void (*kernel)(Types...), void **arguments, std::index_sequence<k...>)
{
    for (blockIdx.x = 0; blockIdx.x < gridDim.x; blockIdx.x++) {
        for (threadIdx.x = 0; threadIdx.x < blockDim.x; threadIdx.x++) {
            kernel(*static_cast<Types *>(arguments[k])...);
        }
    }
}

template <class... Types>
static cudaError_t cudaLaunchKernel(
    void (*kernel)(Types...), dim3 grid, dim3 block, void **arguments, size_t, cudaStream_t)
{
    gridDim = grid;
    blockDim = block;
    run(kernel, arguments, std::index_sequence_for<Types...>{});
    return cudaSuccess;
}

#endif
