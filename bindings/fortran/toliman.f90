! libtoliman for Fortran 2018: one self-contained source. Raw bind(C) interfaces of include/toliman/period.h and a few
! of base.h; the C header is the manual. Every function returns a status; toliman_message() gives the text of a failure.
module toliman
    use, intrinsic :: iso_c_binding
    implicit none
    private
    public :: toliman_message

    integer(c_int32_t), parameter, public :: TOLIMAN_OK = 0
    integer(c_int32_t), parameter, public :: TOLIMAN_PERIOD_AT_EDGE = 1 ! in a peak's flags
    integer(c_int32_t), parameter, public :: TOLIMAN_FAP_BALUEV = 0, TOLIMAN_FAP_NAIVE = 1, TOLIMAN_FAP_SINGLE = 2
    integer(c_int32_t), parameter, public :: TOLIMAN_FAP_SEQUENTIAL = 3

    integer(c_int32_t), parameter, public :: TOLIMAN_POWER_STANDARD = 0, TOLIMAN_POWER_MODEL = 1
    integer(c_int32_t), parameter, public :: TOLIMAN_POWER_LOG = 2, TOLIMAN_POWER_PSD = 3

    type, bind(C), public :: toliman_period_options
        integer(c_int32_t) :: struct_size
        integer(c_int32_t) :: flags
        real(c_double) :: time_offset, value_offset, value_bound, sigma_floor, sigma_ceiling
        integer(c_int64_t) :: time_offset_ns
        real(c_double) :: unit_ns
        type(c_ptr) :: allocator
    end type

    type, bind(C), public :: toliman_period_peak
        integer(c_int32_t) :: struct_size
        integer(c_int32_t) :: flags
        real(c_double) :: frequency, period, power, log10_residual, fwhm, fwhm_error, half_width_error
        real(c_double) :: frequency_error, amplitude, amplitude_error, phase, offset, log10_fap
        real(c_double) :: period_error
    end type

    interface
        function toliman_abi_version() bind(C) result(version)
            import :: c_int32_t
            integer(c_int32_t) :: version
        end function

        function toliman_last_error_copy(text, size) bind(C) result(length)
            import :: c_char, c_size_t
            character(kind=c_char), intent(out) :: text(*)
            integer(c_size_t), value :: size
            integer(c_size_t) :: length
        end function

        subroutine toliman_period_options_init(options) bind(C)
            import :: toliman_period_options
            type(toliman_period_options), intent(out) :: options
        end subroutine

        function toliman_period_create(f0, df, nf, options, period) bind(C) result(status)
            import :: c_double, c_int64_t, c_int32_t, c_ptr, toliman_period_options
            real(c_double), value :: f0, df
            integer(c_int64_t), value :: nf
            type(toliman_period_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: period
            integer(c_int32_t) :: status
        end function

        subroutine toliman_period_destroy(period) bind(C)
            import :: c_ptr
            type(c_ptr), value :: period
        end subroutine

        function toliman_period_push(period, t, y, sigma) bind(C) result(status)
            import :: c_double, c_int32_t, c_ptr
            type(c_ptr), value :: period
            real(c_double), value :: t, y, sigma
            integer(c_int32_t) :: status
        end function

        ! sigma absent: unweighted
        function toliman_period_push_many(period, t, y, sigma, n) bind(C) result(status)
            import :: c_double, c_int32_t, c_size_t, c_ptr
            type(c_ptr), value :: period
            real(c_double), intent(in) :: t(*), y(*)
            real(c_double), intent(in), optional :: sigma(*)
            integer(c_size_t), value :: n
            integer(c_int32_t) :: status
        end function

        function toliman_period_reset(period) bind(C) result(status)
            import :: c_int32_t, c_ptr
            type(c_ptr), value :: period
            integer(c_int32_t) :: status
        end function

        function toliman_period_count(period) bind(C) result(count)
            import :: c_int64_t, c_ptr
            type(c_ptr), value :: period
            integer(c_int64_t) :: count
        end function

        ! Frequencies first ... first + count - 1, counted from 0 as in C; normalisation: TOLIMAN_POWER_STANDARD, ...
        function toliman_period_query_power(period, normalisation, first, count, power) bind(C) result(status)
            import :: c_double, c_int32_t, c_int64_t, c_size_t, c_ptr
            type(c_ptr), value :: period
            integer(c_int32_t), value :: normalisation
            integer(c_int64_t), value :: first
            integer(c_size_t), value :: count
            real(c_double), intent(out) :: power(*)
            integer(c_int32_t) :: status
        end function

        ! Set peak%struct_size = c_sizeof(peak) first.
        function toliman_period_query_peak(period, peak) bind(C) result(status)
            import :: c_int32_t, c_ptr, toliman_period_peak
            type(c_ptr), value :: period
            type(toliman_period_peak), intent(inout) :: peak
            integer(c_int32_t) :: status
        end function

        function toliman_period_query_fit(period, t, y, sigma, n, peak) bind(C) result(status)
            import :: c_double, c_int32_t, c_size_t, c_ptr, toliman_period_peak
            type(c_ptr), value :: period
            real(c_double), intent(in) :: t(*), y(*)
            real(c_double), intent(in), optional :: sigma(*)
            integer(c_size_t), value :: n
            type(toliman_period_peak), intent(inout) :: peak
            integer(c_int32_t) :: status
        end function

        function toliman_period_query_fap(period, method, log10_residual, log10_fap) bind(C) result(status)
            import :: c_double, c_int32_t, c_ptr
            type(c_ptr), value :: period
            integer(c_int32_t), value :: method
            real(c_double), value :: log10_residual
            real(c_double), intent(out) :: log10_fap
            integer(c_int32_t) :: status
        end function

        function toliman_period_query_level(period, method, log10_fap, log10_residual) bind(C) result(status)
            import :: c_double, c_int32_t, c_ptr
            type(c_ptr), value :: period
            integer(c_int32_t), value :: method
            real(c_double), value :: log10_fap
            real(c_double), intent(out) :: log10_residual
            integer(c_int32_t) :: status
        end function

        ! path must end in c_null_char
        function toliman_period_save_file(period, path) bind(C) result(status)
            import :: c_char, c_int32_t, c_ptr
            type(c_ptr), value :: period
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int32_t) :: status
        end function

        function toliman_period_load_file(path, allocator, period) bind(C) result(status)
            import :: c_char, c_int32_t, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: allocator
            type(c_ptr), intent(out) :: period
            integer(c_int32_t) :: status
        end function
    end interface

    public :: toliman_abi_version, toliman_period_options_init, toliman_period_create, toliman_period_destroy
    public :: toliman_period_push, toliman_period_push_many, toliman_period_reset, toliman_period_count
    public :: toliman_period_query_power, toliman_period_query_peak, toliman_period_query_fit
    public :: toliman_period_query_fap, toliman_period_query_level, toliman_period_save_file, toliman_period_load_file

contains

    ! Message of the last failed call on this thread.
    function toliman_message() result(message)
        character(len=:), allocatable :: message
        character(kind=c_char) :: text(1024)
        integer(c_size_t) :: length, i
        length = min(toliman_last_error_copy(text, size(text, kind=c_size_t)), size(text, kind=c_size_t) - 1)
        allocate (character(len=length) :: message)
        do i = 1, length
            message(i:i) = text(i)
        end do
    end function

end module toliman
